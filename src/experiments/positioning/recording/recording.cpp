#include "cosiva/experiments/positioning/recording/recording.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/recording/fields.h"
#include "cosiva/experiments/positioning/recording/heading.h"
#include "cosiva/experiments/positioning/recording/silence.h"

namespace cosiva::experiments {
namespace {

using Row = std::vector<double>;

Result<void> rising(const RecordingTable& table, std::size_t column) {
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    if (table.rows[i][column] > table.rows[i - 1][column]) continue;
    return fail("recording.stamp", "the stamp is not later than the previous stamp",
                table.file + ", row " + std::to_string(i + 1));
  }
  return {};
}

Result<std::uint32_t> beacon_number(double value, const std::string& file) {
  if (value >= 0.0 && value < 4294967295.0 && value == std::floor(value)) return static_cast<std::uint32_t>(value);
  return fail("recording.beacon", "a beacon's number must be an integer", file);
}

/// Measurements may be logged late; they are sorted by their stamps, and this is reported.
template <typename T>
void put_in_order(std::vector<T>& all, std::string_view what, Recording& recording) {
  std::size_t late = 0;
  double latest_s = -1e300;
  for (const T& one : all) {
    if (one.t_s < latest_s) ++late;
    latest_s = std::fmax(latest_s, one.t_s);
  }
  if (late == 0) return;
  std::ranges::stable_sort(all, {}, &T::t_s);
  recording.diagnostics.push_back(std::to_string(late) + " " + std::string(what) +
                                  " were logged after later ones; they are used in the order of their stamps");
}

/// Finds columns by name, in the requested order.
Result<std::vector<std::size_t>> columns_of(const RecordingTable& table,
                                            std::initializer_list<std::string_view> names) {
  std::vector<std::size_t> found;
  for (const auto name : names) {
    const auto column = table.need(name);
    if (!column) return tl::unexpected(column.error());
    found.push_back(*column);
  }
  return found;
}

Result<void> read_odometry(const RecordingTable& table, Recording& recording) {
  const bool speeds = table.find("speed_mps").has_value();
  const auto columns = speeds ? columns_of(table, {"time_s", "speed_mps", "turn_radps"})
                              : columns_of(table, {"time_s", "delta_distance_m", "delta_heading_rad"});
  if (!columns) return tl::unexpected(columns.error());
  const auto& c = *columns;
  if (auto fine = rising(table, c[0]); !fine) return fine;
  const auto left = table.want(speeds ? "speed_left_mps" : "delta_left_m");
  if (!left) return tl::unexpected(left.error());
  recording.odometry_had_speeds = speeds;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const Row& row = table.rows[i];
    // The first increment began some time before its stamp; about as long as the second one.
    const double before =
        i > 0 ? table.rows[i - 1][c[0]] : row[c[0]] - (table.rows.size() > 1 ? table.rows[1][c[0]] - row[c[0]] : 0.1);
    const double duration_s = row[c[0]] - before;
    const double factor = speeds ? duration_s : 1.0;
    recording.odometry.push_back(
        {row[c[0]], duration_s, row[c[1]] * factor, row[c[2]] * factor, 0.0, 0.0, *left ? row[**left] * factor : 0.0});
  }
  return {};
}

Result<void> read_ground_truth(const RecordingTable& table, Recording& recording) {
  const auto columns = columns_of(table, {"time_s", "x_m", "y_m"});
  if (!columns) return tl::unexpected(columns.error());
  const auto& c = *columns;
  if (auto fine = rising(table, c[0]); !fine) return fine;
  const auto heading = table.want("heading_rad");
  if (!heading) return tl::unexpected(heading.error());
  recording.ground_truth_has_heading = heading->has_value();
  for (const Row& row : table.rows)
    recording.ground_truth.push_back({row[c[0]], {row[c[1]], row[c[2]]}, *heading ? row[**heading] : 0.0});
  return {};
}

Result<void> read_beacons(const RecordingTable& table, Recording& recording) {
  const auto columns = columns_of(table, {"beacon_id", "x_m", "y_m"});
  if (!columns) return tl::unexpected(columns.error());
  const auto& c = *columns;
  for (const Row& row : table.rows) {
    const auto number = beacon_number(row[c[0]], table.file);
    if (!number) return tl::unexpected(number.error());
    if (!recording.beacons.emplace(*number, Point2{row[c[1]], row[c[2]]}).second)
      return fail("recording.beacon", "beacon " + std::to_string(*number) + " is surveyed twice", table.file);
  }
  return {};
}

Result<void> read_ranges(const RecordingTable& table, Recording& recording) {
  const auto columns =
      columns_of(table, {"time_s", table.find("receiver_id") ? "receiver_id" : "beacon_id", "range_m"});
  if (!columns) return tl::unexpected(columns.error());
  const auto& c = *columns;
  for (const Row& row : table.rows) {
    const auto number = beacon_number(row[c[1]], table.file);
    if (!number) return tl::unexpected(number.error());
    recording.ranges.push_back({row[c[0]], *number, row[c[2]]});
  }
  return {};
}

Result<void> read_readings(const RecordingTable& table, Recording& recording) {
  const auto columns = columns_of(table, {"time_s", "beacon_id"});
  if (!columns) return tl::unexpected(columns.error());
  const auto& c = *columns;
  const auto ahead = table.want("ahead_m");
  const auto left = table.want("left_m");
  if (!ahead) return tl::unexpected(ahead.error());
  if (!left) return tl::unexpected(left.error());
  for (const Row& row : table.rows) {
    const auto number = beacon_number(row[c[1]], table.file);
    if (!number) return tl::unexpected(number.error());
    recording.readings.push_back({row[c[0]], *number, {*ahead ? row[**ahead] : 0.0, *left ? row[**left] : 0.0}});
  }
  return {};
}

/// Lines name,value: the names are text, so this is no table of numbers.
Result<void> read_sensors(std::string_view file, std::string_view text, Recording& recording) {
  Lines lines{text};
  std::string_view line;
  std::optional<char> separator;
  while (lines.next(line)) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (!separator) {
      separator = separator_of(line);
      continue;
    }
    const auto fields = cut_at(*separator, line);
    const auto value = fields.size() == 2 ? finite_number(fields[1]) : std::nullopt;
    if (!value || *value < 0.0)
      return fail("recording.sensors", "a line contains a sensor parameter and its value, name,value",
                  location_of(file, lines.number()));
    recording.sensors[std::string(fields[0])] = *value;
  }
  return {};
}

Result<Recording> read_tables(std::string_view name, const RecordingFiles& files) {
  Recording recording;
  recording.name = name;
  struct Part {
    const char* file;
    bool needed;
    Result<void> (*read)(const RecordingTable&, Recording&);
  };
  for (const Part& part : {Part{"odometry.csv", true, read_odometry}, Part{"groundtruth.csv", true, read_ground_truth},
                           Part{"beacons.csv", false, read_beacons}, Part{"ranges.csv", false, read_ranges},
                           Part{"readings.csv", false, read_readings}}) {
    const auto found = files.find(part.file);
    if (found == files.end()) {
      if (part.needed) return fail("recording.missing", "there is no " + std::string(part.file), std::string(name));
      continue;
    }
    const auto table = RecordingTable::read(part.file, found->second);
    if (!table) return tl::unexpected(table.error());
    if (table->rows.empty()) return fail("recording.empty", "there are no lines below its header", part.file);
    if (auto fine = part.read(*table, recording); !fine) return tl::unexpected(fine.error());
  }
  return recording;
}

// ---- libRSF's text
// ---------------------------------------------------------------------------------------------------

struct TextLine {
  std::string_view kind;
  std::vector<double> values;
  std::string location;
};

/// Selects lines of some kinds; comments and other kinds of libRSF are ignored.
template <typename Take>
Result<void> each_line(std::string_view file, std::string_view text, const std::vector<std::string_view>& kinds,
                       const Take& take) {
  Lines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    const auto fields = cut_at_spaces(line);
    if (fields.empty() || std::ranges::find(kinds, fields.front()) == kinds.end()) continue;
    TextLine one{fields.front(), {}, location_of(file, lines.number())};
    for (std::size_t i = 1; i < fields.size(); ++i) {
      const auto value = finite_number(fields[i]);
      if (!value) return fail("recording.number", "'" + std::string(fields[i]) + "' is no finite number", one.location);
      one.values.push_back(*value);
    }
    if (auto fine = take(one); !fine) return fine;
  }
  return {};
}

Result<void> too_short(const TextLine& line, std::size_t wanted) {
  return fail("recording.width",
              std::string(line.kind) + " has " + std::to_string(line.values.size()) + " numbers instead of " +
                  std::to_string(wanted),
              line.location);
}

/// Odometry begins as speeds, which become distances when their durations are known.
Result<void> take_speeds(const Recording::Step& step, const TextLine& line, Recording& recording) {
  if (!recording.odometry.empty() && !(step.t_s > recording.odometry.back().t_s))
    return fail("recording.stamp", "the stamp is not later than the previous stamp", line.location);
  recording.odometry.push_back(step);
  return {};
}

/// range2 t range variance x y id snr · odom2diff t left right lateral half_track var var var · odom2 t ahead left turn
/// var var var.
Result<void> take_input(const TextLine& line, Recording& recording) {
  const auto& v = line.values;
  if (line.kind == "range2") {
    if (v.size() < 6) return too_short(line, 6);
    const auto number = beacon_number(v[5], line.location);
    if (!number) return tl::unexpected(number.error());
    recording.beacons[*number] = {v[3], v[4]};
    recording.ranges.push_back({v[0], *number, v[1]});
  } else if (line.kind == "odom2diff") {
    if (v.size() < 5) return too_short(line, 5);
    if (!(v[4] > 0.0)) return fail("recording.number", "half the track must be more than 0", line.location);
    recording.turns_from_wheels = true;
    return take_speeds({v[0], 0.0, 0.5 * (v[1] + v[2]), (v[2] - v[1]) / (2.0 * v[4])}, line, recording);
  } else if (line.kind == "odom2") {
    if (v.size() < 4) return too_short(line, 4);
    return take_speeds({v[0], 0.0, v[1], v[3], 0.0, 0.0, v[2]}, line, recording);
  }
  return {};
}

/// point2 t x y … · angle t heading …
Result<void> take_ground_truth(const TextLine& line, Recording& recording, std::map<double, double>& headings) {
  const auto& v = line.values;
  if (line.kind == "angle") {
    if (v.size() < 2) return too_short(line, 2);
    headings[v[0]] = v[1];
    return {};
  }
  if (v.size() < 3) return too_short(line, 3);
  if (!recording.ground_truth.empty() && !(v[0] > recording.ground_truth.back().t_s))
    return fail("recording.stamp", "the stamp is not later than the previous stamp", line.location);
  recording.ground_truth.push_back({v[0], {v[1], v[2]}, 0.0});
  return {};
}

/// libRSF's odom2 moves in the direction at the beginning of a step, and turns at its end: the arc with the same two
/// ends.
void bend(Recording::Step& step) {
  // For a full turn in one step there is no such arc.
  if (std::fabs(step.turn_rad) >= 6.0) return;
  const SinCos turn = sincos(step.turn_rad);
  const bool straight = std::fabs(step.turn_rad) < 1e-4;
  const double ahead = straight ? 1.0 - step.turn_rad * step.turn_rad / 6.0 : turn.sin / step.turn_rad;
  const double aside = straight ? 0.5 * step.turn_rad : (1.0 - turn.cos) / step.turn_rad;
  const double squared = ahead * ahead + aside * aside;
  const double x_m = step.distance_m;
  const double y_m = step.left_m;
  step.distance_m = (ahead * x_m + aside * y_m) / squared;
  step.left_m = (ahead * y_m - aside * x_m) / squared;
}

Result<Recording> read_librsf(std::string_view name, std::string_view input, std::string_view ground_truth,
                              const RecordingFiles& files) {
  Recording recording;
  recording.name = name;
  const auto text_of = [&](std::string_view file) -> std::string_view { return files.find(std::string(file))->second; };
  bool goes_then_turns = false;
  const auto reported = [&](const TextLine& line) {
    goes_then_turns = goes_then_turns || line.kind == "odom2";
    return take_input(line, recording);
  };
  std::map<double, double> headings;
  const auto true_position = [&](const TextLine& line) { return take_ground_truth(line, recording, headings); };
  if (auto fine = each_line(input, text_of(input), {"range2", "odom2diff", "odom2"}, reported); !fine)
    return tl::unexpected(fine.error());
  if (auto fine = each_line(ground_truth, text_of(ground_truth), {"point2", "angle"}, true_position); !fine)
    return tl::unexpected(fine.error());
  if (recording.odometry.size() < 2) return fail("recording.empty", "there is no odometry in it", std::string(input));
  if (recording.ground_truth.empty())
    return fail("recording.empty", "there is no ground truth in it", std::string(ground_truth));
  const auto has_heading = [&](const Recording::True& one) { return headings.contains(one.t_s); };
  recording.ground_truth_has_heading = std::ranges::all_of(recording.ground_truth, has_heading);
  if (recording.ground_truth_has_heading) {
    for (Recording::True& one : recording.ground_truth) one.heading_rad = headings[one.t_s];
  }
  recording.odometry_had_speeds = true;
  // A speed is measured over the time that ends with its stamp.
  for (std::size_t i = recording.odometry.size(); i-- > 0;) {
    Recording::Step& step = recording.odometry[i];
    step.duration_s = i > 0 ? step.t_s - recording.odometry[i - 1].t_s : recording.odometry[1].duration_s;
    step.distance_m *= step.duration_s;
    step.left_m *= step.duration_s;
    step.turn_rad *= step.duration_s;
    if (goes_then_turns) bend(step);
  }
  return recording;
}

}  // namespace

namespace {

/// A file that is no text has a zero byte early: another encoding, a packed file, a table of another program.
Result<void> check_texts(const RecordingFiles& files) {
  for (const auto& [file, text] : files) {
    if (text.find('\0') != std::string::npos)
      return fail("recording.text", "the file is no plain text (UTF-8 or ASCII)", file);
  }
  return {};
}

/// A radio without a response often reports 0 or -1, which is no distance.
void drop_no_distances(Recording& recording) {
  const auto dropped =
      std::erase_if(recording.ranges, [](const Recording::ReceivedRange& received) { return received.range_m <= 0.0; });
  if (dropped > 0)
    recording.diagnostics.push_back(std::to_string(dropped) +
                                    " ranges are no distances (0 or less); they are left out");
}

Result<Recording> read_either(std::string_view name, const RecordingFiles& files) {
  if (auto fine = check_texts(files); !fine) return tl::unexpected(fine.error());
  if (files.contains("odometry.csv")) return read_tables(name, files);
  std::string input;
  std::string ground_truth;
  for (const auto& [file, text] : files) {
    if (file.ends_with("Input.txt")) input = file;
    if (file.ends_with("GT.txt")) ground_truth = file;
  }
  if (!input.empty() && !ground_truth.empty()) return read_librsf(name, input, ground_truth, files);
  return fail("recording.missing",
              "there is neither an odometry.csv with a groundtruth.csv, nor libRSF's …Input.txt with a …GT.txt",
              std::string(name));
}

}  // namespace

Result<Recording> read_recording(std::string_view name, const RecordingFiles& files) {
  auto recording = read_either(name, files);
  if (!recording) return recording;
  if (const auto found = files.find("sensors.csv"); found != files.end()) {
    if (auto fine = read_sensors("sensors.csv", found->second, *recording); !fine) return tl::unexpected(fine.error());
  }
  drop_no_distances(*recording);
  bridge_silences(*recording, recording->odometry_had_speeds);
  check_heading(*recording);
  put_in_order(recording->ranges, "ranges", *recording);
  put_in_order(recording->readings, "readings", *recording);
  return recording;
}

}  // namespace cosiva::experiments
