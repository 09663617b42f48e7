#include "cosiva/experiments/transport/site/site_plan.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <exception>
#include <set>
#include <tuple>
#include <utility>

#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/zone/toml/toml_node.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::experiments {
namespace {

using zone::in_quotes;
using zone::nearest;
using zone::NumberRange;

constexpr std::size_t bytes_max = 1U << 22U;
constexpr std::size_t text_max = 4096;
constexpr std::int64_t aivs_max = 10'000'000;
constexpr NumberRange takes_range_s{"seconds from 0.2 to 100000", 0.2, 1e5};

/// "zone" or "zone/station".
std::pair<std::string, std::string> end_of(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return {text, {}};
  return {text.substr(0, slash), text.substr(slash + 1)};
}

void check_zone(const Entry& entry, const char* key, const std::string& name, const std::set<std::string>& names) {
  if (names.contains(name)) return;
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string_view meant = nearest(name, known);
  entry.fault(key, "site.value",
              "there is no zone " + in_quotes(name) + (meant.empty() ? "" : "; is " + in_quotes(meant) + " meant?"));
}

SitePlan read(const Entry& root) {
  SitePlan plan;
  std::set<std::string> names;
  root.expect_only({"zone", "transfer_point"});
  for (const Entry& entry : root.tables("zone", site_zones_max)) {
    entry.expect_only({"name", "file", "aivs"});
    SitePlan::Zone zone;
    zone.file = entry.text("file", text_max);
    zone.name = entry.text("name", text_max, zone.file);
    zone.aivs = static_cast<std::size_t>(entry.whole("aivs", 0, aivs_max, 12));
    if (!names.insert(zone.name).second)
      entry.fault("name", "site.value",
                  "there are two zones " + in_quotes(zone.name) + "; give each a name of its own");
    if (zone.name.find('/') != std::string::npos)
      entry.fault("name", "site.value", "a zone's name has no '/', which separates a zone and its station");
    plan.zones.push_back(std::move(zone));
  }
  for (const Entry& entry : root.tables("transfer_point", site_zones_max)) {
    entry.expect_only({"from", "to", "takes_s", "bidirectional"});
    SitePlan::TransferPoint transfer_point;
    std::tie(transfer_point.from_zone, transfer_point.from_station) = end_of(entry.text("from", text_max));
    std::tie(transfer_point.to_zone, transfer_point.to_station) = end_of(entry.text("to", text_max));
    transfer_point.takes_s = entry.number("takes_s", takes_range_s, 10.0);
    check_zone(entry, "from", transfer_point.from_zone, names);
    check_zone(entry, "to", transfer_point.to_zone, names);
    if (transfer_point.from_zone == transfer_point.to_zone)
      entry.fault("to", "site.value", "a transfer point leads into another zone, and this one back into its own");
    plan.transfer_points.push_back(transfer_point);
    if (entry.one_of("bidirectional", {"yes", "no"}, "no") == "no") continue;
    std::swap(transfer_point.from_zone, transfer_point.to_zone);
    std::swap(transfer_point.from_station, transfer_point.to_station);
    plan.transfer_points.push_back(std::move(transfer_point));
  }
  if (plan.zones.empty()) root.fault("", "site.value", "a site needs at least one [[zone]]");
  return plan;
}

}  // namespace

Result<SitePlan> read_site_plan(std::string_view text, std::string_view origin) {
  const std::string name{origin};
  if (text.size() > bytes_max) return fail("site.file", "a site's file has at most 4 MiB", name);
  zone::TomlFaults faults{name, Entry::family};
  try {
    const toml::table root = toml::parse(text);
    SitePlan plan = read(Entry{faults, root, ""});
    if (faults.any()) return tl::unexpected(faults.first());
    return plan;
  } catch (const toml::parse_error& error) {
    faults.add("site.file", static_cast<std::uint32_t>(error.source().begin.line), "",
               std::string{error.description()});
    return tl::unexpected(faults.first());
  } catch (const std::exception& error) {
    return fail("site.file", std::string("cannot be read: ") + error.what(), name);
  }
}

Result<SitePlan> site_plan_of_list(std::string_view list, std::size_t aivs, double takes_s) {
  SitePlan plan;
  for (std::string_view left = list; !left.empty();) {
    const std::size_t comma = left.find(',');
    std::string_view item = left.substr(0, comma);
    left.remove_prefix(comma == std::string_view::npos ? left.size() : comma + 1);
    std::uint32_t times = 1;
    if (const std::size_t star = item.find('*'); star != std::string_view::npos) {
      const auto [end, error] = std::from_chars(item.data(), item.data() + star, times);
      if (error != std::errc{} || end != item.data() + star || times == 0 || times > site_zones_max)
        return fail("site.list", in_quotes(item) + " begins with no number of zones from 1 to 100000",
                    std::string{list});
      item.remove_prefix(star + 1);
    }
    if (item.empty()) return fail("site.list", "a zone's name is missing", std::string{list});
    for (std::uint32_t k = 0; k < times; ++k) {
      if (plan.zones.size() == site_zones_max)
        return fail("site.list", "a site has at most 100000 zones", std::string{list});
      plan.zones.push_back({std::to_string(plan.zones.size() + 1) + "_" + std::string{item}, std::string{item}, aivs});
    }
  }
  if (plan.zones.empty()) return fail("site.list", "no zones are named", std::string{list});
  const std::size_t count = plan.zones.size();
  for (std::size_t z = 0; z < count && count > 1; ++z) {
    const std::size_t next = (z + 1) % count;
    plan.transfer_points.push_back({plan.zones[z].name, "", plan.zones[next].name, "", takes_s});
  }
  // And back: with two zones the loop already has both directions.
  for (std::size_t z = 0; z < count && count > 2; ++z)
    plan.transfer_points.push_back({plan.zones[(z + 1) % count].name, "", plan.zones[z].name, "", takes_s});
  return plan;
}

}  // namespace cosiva::experiments
