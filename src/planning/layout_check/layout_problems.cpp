#include "cosiva/planning/layout_check/layout_problems.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

using zone::Problem;

constexpr std::size_t listed_max = 20;
constexpr std::size_t named_max = 5;

/// Collects the sentences. Invariant: `counts_` has the number of problems of each code, of which at most `listed_max`
/// are listed.
class Sentences {
 public:
  Sentences(const zone::TrafficZone& zone, const WellFormed& found) : zone_{zone}, found_{found} {}

  std::vector<Problem> all();

 private:
  using Severity = Problem::Severity;

  void record(Severity severity, const std::string& code, std::size_t station, std::string text);
  void record_others();
  void state_station(std::size_t station, bool any_transport);
  [[nodiscard]] std::string name(std::size_t station) const { return "'" + zone_.stations[station].name + "'"; }
  [[nodiscard]] std::string names(const std::vector<std::size_t>& stations) const;
  [[nodiscard]] Problem problem(Severity severity, std::string code, std::size_t station, std::string text) const;

  const zone::TrafficZone& zone_;
  const WellFormed& found_;
  std::vector<Problem> problems_;
  std::map<std::string, std::pair<std::size_t, std::size_t>> counts_;  // by code: number, and the last station
};

Problem Sentences::problem(Severity severity, std::string code, std::size_t station, std::string text) const {
  const zone::TrackPosition at = zone_.stations[station].position;
  return {severity, std::move(code), at, position(zone_.circuit.pose_at(at)), std::move(text)};
}

void Sentences::record(Severity severity, const std::string& code, std::size_t station, std::string text) {
  COSIVA_EXPECT(station < zone_.stations.size() && problems_.size() <= counts_.size() * listed_max);
  auto& [count, last] = counts_[code];
  last = station;
  if (++count <= listed_max) problems_.push_back(problem(severity, code, station, std::move(text)));
}

void Sentences::record_others() {
  for (const auto& [code, counted] : counts_) {
    if (counted.first <= listed_max) continue;
    const auto like = std::ranges::find(problems_, code, &Problem::code);
    problems_.push_back(problem(like->severity, code, counted.second,
                                "and " + std::to_string(counted.first - listed_max) +
                                    " more stations like those above, up to station " + name(counted.second)));
  }
}

std::string Sentences::names(const std::vector<std::size_t>& stations) const {
  std::string text = stations.size() == 1 ? "station " : "stations ";
  const std::size_t named = std::min(named_max, stations.size());
  for (std::size_t i = 0; i < named; ++i) text += (i == 0 ? "" : ", ") + name(stations[i]);
  if (stations.size() > named) text += " and " + std::to_string(stations.size() - named) + " more";
  return text;
}

void Sentences::state_station(std::size_t station, bool any_transport) {
  const WellFormed::Finding& found = found_.stations()[station];
  if (!found.is_entered)
    record(Severity::warning, "layout.no_entry", station,
           "no vehicle can arrive at station " + name(station) + "; let a section lead to it");
  else if (!found.is_left)
    record(
        Severity::warning, "layout.no_exit", station,
        "station " + name(station) +
            " can be entered but not left; let vehicles turn on the spot there (pivots), or add a section that leads "
            "back");
  else if (!found.reaches_another && any_transport)
    record(
        Severity::warning, "layout.no_onward", station,
        "from station " + name(station) + " no other station can be reached; add a section that leads to one of them");
  if (!found.cut_off.empty())
    record(Severity::notice, "layout.cut", station,
           "a vehicle at station " + name(station) + " cuts off " + names(found.cut_off) +
               " from the others; give the station a bay of its own, or add sections that lead round it");
}

std::vector<Problem> Sentences::all() {
  const auto& stations = found_.stations();
  if (stations.empty()) return {};
  const bool any_transport = std::ranges::any_of(stations, &WellFormed::Finding::reaches_another);
  if (!any_transport && stations.size() > 1)
    record(Severity::warning, "layout.no_transport", 0,
           "no station can be reached from another one, so that no transport is possible; add sections that lead from "
           "station to station, or let vehicles turn on the spot (pivots) where sections end");
  for (std::size_t station = 0; station < stations.size(); ++station) state_station(station, any_transport);
  if (const auto station = found_.obstructed(); station && any_transport)
    record(Severity::notice, "layout.obstructed", *station,
           "with vehicles stopped at all other stations no vehicle can reach and leave station " + name(*station) +
               "; the layout is not well-formed, so that a plan for as many vehicles as stations may not exist");
  record_others();
  if (found_.examined() < stations.size())
    problems_.push_back(problem(Severity::notice, "layout.cut", found_.examined(),
                                "whether a vehicle at a station cuts off others was examined for the first " +
                                    std::to_string(found_.examined()) + " of " + std::to_string(stations.size()) +
                                    " stations only"));
  std::ranges::stable_sort(problems_, {}, [](const Problem& p) { return p.severity; });
  return std::move(problems_);
}

}  // namespace

std::vector<Problem> layout_problems(const zone::TrafficZone& zone, const WellFormed& found) {
  return Sentences{zone, found}.all();
}

}  // namespace cosiva::planning
