#include "cosiva/experiments/transport/site/site.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>
#include <type_traits>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/random.h"

namespace cosiva::experiments {
namespace {

/// Spare capacity for vehicles in a zone beyond its initial number: the capacity of all its sections is more than ever
/// arrive.
constexpr std::size_t spare_most = 64;

/// The messages between ranks, field by field; all ranks run the same program on machines of one kind.
class Message {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Takes values from the front of a message, in the order in which they were put.
///
/// Invariant: nothing is taken beyond the message's end.
class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : bytes_{bytes} {}
  template <class T>
  [[nodiscard]] T take() {
    COSIVA_EXPECT(bytes_.size() >= sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }
  [[nodiscard]] bool is_empty() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

/// A transfer point's end by name, or the n-th stop where no name is given.
Result<zone::TrackPosition> end_in(const zone::TrafficZone& zone, const std::string& zone_name,
                                   const std::string& station, std::size_t nth) {
  if (!station.empty()) {
    const zone::Station* const found = zone.find_station(station);
    if (found != nullptr) return found->position;
    return fail("site.transfer_point",
                "zone '" + zone_name + "' has no station '" + station + "' for a transfer point");
  }
  const auto stops = stops_of(zone);
  if (stops.empty())
    return fail("site.transfer_point",
                "zone '" + zone_name + "' has no station where a transfer point could begin or end");
  return zone.stations[stops[std::min(nth, stops.size() - 1)]].position;
}

/// An error of one rank is an error of all ranks: no rank may wait for one that has ended.
Result<void> agree(Ranks& ranks, const Result<void>& mine) {
  const std::string text =
      mine ? std::string{} : mine.error().code + '\n' + mine.error().message + '\n' + mine.error().location;
  const auto all = ranks.exchange(std::vector<std::string>(ranks.size(), text));
  for (const std::string& one : all) {
    if (one.empty()) continue;
    const std::size_t first = one.find('\n');
    const std::size_t last = one.rfind('\n');
    return fail(one.substr(0, first), one.substr(first + 1, last - first - 1), one.substr(last + 1));
  }
  return {};
}

}  // namespace

Result<SiteRun> SiteRun::make(SiteOptions options, Ranks& ranks) {
  SiteRun site{std::move(options), ranks};
  Result<void> laid = site.lay_transfers();
  if (laid) laid = site.open_zones();
  if (auto agreed = agree(ranks, laid); !agreed) return tl::unexpected(agreed.error());
  return site;
}

std::size_t SiteRun::owner_of(std::size_t zone) const { return zone * ranks_->size() / options_.zones.size(); }

SiteRun::SiteZone& SiteRun::site_zone_of(std::size_t zone) {
  COSIVA_EXPECT(!site_zones_.empty() && zone >= site_zones_.front().index &&
                zone - site_zones_.front().index < site_zones_.size());
  return site_zones_[zone - site_zones_.front().index];
}

Result<void> SiteRun::lay_transfers() {
  if (options_.zones.empty() || options_.zones.size() != options_.plan.zones.size())
    return fail("site.options", "a site needs zones, each of them given");
  if (!(options_.away_ratio >= 0.0 && options_.away_ratio <= 1.0))
    return fail("site.options", "the ratio of jobs that lead away must be from 0 to 1");
  std::map<std::string_view, std::size_t> index_of;
  for (const SitePlan::Zone& zone : options_.plan.zones) index_of.emplace(zone.name, index_of.size());
  exits_.resize(options_.zones.size());
  meeting_steps_ = std::max<std::uint64_t>(1, steps_in(10.0, options_.step));
  for (const SitePlan::TransferPoint& transfer_point : options_.plan.transfer_points) {
    const auto from = index_of.find(transfer_point.from_zone);
    const auto to = index_of.find(transfer_point.to_zone);
    if (from == index_of.end() || to == index_of.end())
      return fail("site.transfer_point", "a transfer point leads from '" + transfer_point.from_zone + "' to '" +
                                             transfer_point.to_zone + "', and one of them is no zone");
    const auto enter = end_in(*options_.zones[to->second], transfer_point.to_zone, transfer_point.to_station, 1);
    if (!enter) return tl::unexpected(enter.error());
    const std::uint64_t takes_steps = std::max<std::uint64_t>(1, steps_in(transfer_point.takes_s, options_.step));
    meeting_steps_ = std::min(meeting_steps_, takes_steps);
    exits_[from->second].push_back(transfers_.size());
    transfers_.push_back({to->second, *enter, takes_steps});
  }
  end_steps_ = steps_in(options_.warm_up_s, options_.step) +
               std::max<std::uint64_t>(1, steps_in(options_.duration_s, options_.step));
  return {};
}

Result<TrafficOptions> SiteRun::options_of(std::size_t zone, std::uint32_t first_aiv) const {
  const std::vector<std::size_t>& exits = exits_[zone];
  TrafficOptions traffic;
  const TrafficTerms& terms = options_;
  static_cast<TrafficTerms&>(traffic) = terms;
  traffic.zone = options_.zones[zone];
  traffic.aivs = options_.plan.zones[zone].aivs;
  traffic.first_aiv = first_aiv;
  if (!transfers_.empty()) traffic.spare = std::min(spare_most, traffic.aivs + 8);
  for (const std::size_t transfer_point : exits) {
    const SitePlan::TransferPoint& named = options_.plan.transfer_points[transfer_point];
    const auto leave = end_in(*traffic.zone, named.from_zone, named.from_station, 0);
    if (!leave) return tl::unexpected(leave.error());
    traffic.exits.push_back(*leave);
  }
  if (options_.jobs_per_hour <= 0.0) return traffic;
  // Each zone draws its own random numbers, so that its result does not depend on its rank.
  const std::string stream = "site/" + std::to_string(zone);
  Random random{options_.seed, stream};
  auto jobs =
      poisson_jobs(*traffic.zone, options_.jobs_per_hour, options_.warm_up_s + options_.duration_s, random.next());
  if (!jobs) return tl::unexpected(jobs.error());
  for (Job& job : *jobs) {
    if (exits.empty() || !random.chance(options_.away_ratio)) continue;
    const auto exit = static_cast<std::uint32_t>(random.below(exits.size()));
    const auto stops = stops_of(*options_.zones[transfers_[exits[exit]].to_zone]);
    if (stops.empty()) continue;
    job.exit = exit;
    job.to = stops[random.below(stops.size())];
  }
  traffic.jobs = std::move(*jobs);
  return traffic;
}

Result<void> SiteRun::open_zones() {
  std::uint32_t first_aiv = 0;
  for (std::size_t zone = 0; zone < options_.zones.size(); ++zone) {
    const std::uint32_t first = first_aiv;
    first_aiv += static_cast<std::uint32_t>(options_.plan.zones[zone].aivs);
    if (owner_of(zone) != ranks_->rank()) continue;
    SiteZone site_zone{zone, nullptr, {}, {}};
    const auto in_zone = [&](Error error) {
      error.message = "zone '" + options_.plan.zones[zone].name + "': " + error.message;
      return tl::unexpected(std::move(error));
    };
    auto traffic = options_of(zone, first);
    if (!traffic) return in_zone(traffic.error());
    auto run = TrafficRun::make(std::move(*traffic));
    if (!run) return in_zone(run.error());
    site_zone.run = std::make_unique<TrafficRun>(std::move(*run));
    site_zones_.push_back(std::move(site_zone));
  }
  for (const Transfer& transfer : transfers_) {
    if (owner_of(transfer.to_zone) != ranks_->rank() ||
        site_zone_of(transfer.to_zone).run->fleet().may_stop(transfer.enter))
      continue;
    return fail("site.transfer_point",
                "zone '" + options_.plan.zones[transfer.to_zone].name +
                    "': a transfer point leads to a position in a crossing, where no vehicle may stop");
  }
  return {};
}

void SiteRun::drive(SiteZone& site_zone, std::uint64_t until_step) const {
  AloneWorker alone;
  std::vector<std::size_t>
      blocked;  // transfer points whose first vehicle cannot enter now, which blocks the following ones
  while (site_zone.run->steps() < until_step) {
    site_zone.run->step(alone);
    for (const Traveller& traveller : site_zone.run->take_leaving()) {
      const std::size_t transfer_point = exits_[site_zone.index][traveller.job.exit];
      site_zone.left.emplace_back(transfer_point, traveller);
    }
    blocked.clear();
    for (auto next = site_zone.arrivals.begin();
         next != site_zone.arrivals.end() && next->due_step <= site_zone.run->steps();) {
      const bool waits = std::ranges::find(blocked, next->transfer_point) != blocked.end();
      if (!waits && site_zone.run->bring(next->traveller, transfers_[next->transfer_point].enter)) {
        next = site_zone.arrivals.erase(next);
        continue;
      }
      if (!waits) blocked.push_back(next->transfer_point);
      ++next;
    }
  }
}

bool SiteRun::advance(Workers& workers) {
  if (steps_ >= end_steps_) return false;
  const std::uint64_t until = std::min(end_steps_, steps_ + meeting_steps_);
  workers.for_each(site_zones_.size(), [&](std::size_t i) { drive(site_zones_[i], until); });
  steps_ = until;
  if (!transfers_.empty()) meet();
  return steps_ < end_steps_;
}

void SiteRun::meet() {
  std::vector<Message> messages(ranks_->size());
  for (SiteZone& site_zone : site_zones_) {
    for (const auto& [transfer_point, traveller] : site_zone.left) {
      Message& message = messages[owner_of(transfers_[transfer_point].to_zone)];
      message.put(std::uint64_t{transfer_point});
      message.put(traveller.aiv);
      message.put(traveller.left_step);
      message.put(traveller.job.due_s);
      message.put(std::uint64_t{traveller.job.to});
      message.put(traveller.job.priority);
    }
    site_zone.left.clear();
  }
  std::vector<std::string> texts;
  texts.reserve(messages.size());
  for (Message& message : messages) texts.push_back(message.take());
  const auto responses = ranks_->exchange(std::move(texts));
  for (const std::string& text : responses) {
    for (MessageReader reader{text}; !reader.is_empty();) {
      const auto transfer_point = static_cast<std::size_t>(reader.take<std::uint64_t>());
      Traveller traveller;
      traveller.aiv = reader.take<std::uint32_t>();
      traveller.left_step = reader.take<std::uint64_t>();
      traveller.job.due_s = reader.take<double>();
      traveller.job.to = static_cast<std::size_t>(reader.take<std::uint64_t>());
      traveller.job.priority = reader.take<std::int32_t>();
      COSIVA_EXPECT(transfer_point < transfers_.size());
      site_zone_of(transfers_[transfer_point].to_zone)
          .arrivals.push_back(
              {traveller.left_step + transfers_[transfer_point].takes_steps, transfer_point, traveller});
    }
  }
  // In an order that does not depend on the order of the messages.
  for (SiteZone& site_zone : site_zones_)
    std::ranges::sort(site_zone.arrivals, {}, [](const Arrival& one) {
      return std::tuple{one.due_step, one.transfer_point, one.traveller.aiv};
    });
}

double SiteRun::time_s() const { return to_seconds(options_.step) * static_cast<double>(steps_); }

SiteMetrics SiteRun::metrics() const {
  Message mine;
  for (const SiteZone& site_zone : site_zones_) {
    const TrafficMetrics f = site_zone.run->metrics();
    mine.put(std::uint64_t{site_zone.index});
    for (const std::size_t count : {f.aivs, f.jobs_due, f.jobs_done, f.jobs_came, f.jobs_left, f.stuck})
      mine.put(std::uint64_t{count});
    for (const double value : {f.distance_m, f.waiting_ratio, f.energy_wh, f.vehicle_s}) mine.put(value);
    mine.put(f.near_misses);
    mine.put(f.collisions);
    Digest digest;
    digest.add(std::string_view{f.digest});
    for (const Arrival& arrivals : site_zone.arrivals) {
      digest.add(arrivals.due_step);
      digest.add(std::uint64_t{arrivals.traveller.aiv});
    }
    mine.put(digest.value());
  }
  const std::string text = mine.take();
  const auto all = ranks_->exchange(std::vector<std::string>(ranks_->size(), text));

  SiteMetrics metrics;
  metrics.zones.resize(options_.zones.size());
  double vehicle_s = 0.0;
  std::size_t present = 0;
  for (const std::string& one : all) {
    for (MessageReader reader{one}; !reader.is_empty();) {
      const auto index = static_cast<std::size_t>(reader.take<std::uint64_t>());
      COSIVA_EXPECT(index < metrics.zones.size());
      SiteMetrics::Zone& zone = metrics.zones[index];
      zone.name = options_.plan.zones[index].name;
      for (std::size_t* count : {&zone.aivs, &zone.jobs_due, &zone.jobs_done, &zone.came, &zone.left, &zone.stuck})
        *count = static_cast<std::size_t>(reader.take<std::uint64_t>());
      zone.distance_m = reader.take<double>();
      zone.waiting_ratio = reader.take<double>();
      zone.energy_wh = reader.take<double>();
      vehicle_s += reader.take<double>();
      zone.near_misses = reader.take<std::uint64_t>();
      zone.collisions = reader.take<std::uint64_t>();
      zone.digest = reader.take<std::uint64_t>();
      present += zone.aivs;
    }
  }
  for (const SitePlan::Zone& zone : options_.plan.zones) metrics.aivs += zone.aivs;
  metrics.in_transfer = metrics.aivs - present;
  metrics.vehicle_steps = static_cast<std::uint64_t>(std::llround(vehicle_s / to_seconds(options_.step)));
  Digest digest;
  for (const SiteMetrics::Zone& zone : metrics.zones) digest.add(zone.digest);
  metrics.digest = digest.hex();
  return metrics;
}

}  // namespace cosiva::experiments
