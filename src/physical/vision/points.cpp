#include "cosiva/physical/vision/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/text.h"
#include "cosiva/physical/vision/table.h"

namespace cosiva::vision {
namespace {

/// The line of a duplicate point, by its floor position or by its pixel.
Result<void> check_distinct(const Table& table, std::size_t column, const std::string& what, const std::string& file) {
  struct At {
    double a, b;
    std::size_t line;
  };
  std::vector<At> all;
  for (const auto& [line, row] : table.rows) all.push_back({row[column], row[column + 1], line});
  std::ranges::sort(all,
                    [](const At& l, const At& r) { return std::tie(l.a, l.b, l.line) < std::tie(r.a, r.b, r.line); });
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].a == all[i - 1].a && all[i].b == all[i - 1].b)
      return fail("gvs.points", what + " is in line " + std::to_string(all[i - 1].line) + " already",
                  location_of(file, all[i].line));
  return {};
}

constexpr double degree_rad = pi / 180.0;

/// Sums over one pose's samples. Invariant: a mean is of at least one sample.
class Stop {
 public:
  void add(const std::array<double, 4>& row) {
    for (std::size_t i = 0; i < 4; ++i) sum_[i] += row[i];
    squares_ += row[0] * row[0] + row[1] * row[1];
    ++count_;
  }
  [[nodiscard]] SurveyedPose mean(const Pose2& surveyed) const {
    COSIVA_EXPECT(count_ > 0);
    const double n = static_cast<double>(count_);
    const double x = sum_[0] / n;
    const double y = sum_[1] / n;
    const double spread = std::max(0.0, squares_ / n - x * x - y * y);
    return {surveyed, {x, y, det_atan2(sum_[3], sum_[2])}, count_, std::sqrt(0.5 * spread)};
  }

 private:
  std::array<double, 4> sum_{};
  double squares_{0.0};
  std::size_t count_{0};
};

std::optional<std::array<double, 4>> sample_of(std::string_view line) {
  const auto fields = cut(line, ',');
  if (fields.size() < 4 || fields.size() > 5) return std::nullopt;
  std::array<double, 4> row{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto number = number_of<double>(fields[i]);
    if (!number || std::fabs(*number) > 1e6) return std::nullopt;
    row[i] = *number;
  }
  const double length = norm(row[2], row[3]);
  if (length < 0.5 || length > 1.5) return std::nullopt;
  return row;
}

double between(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

}  // namespace

Result<std::vector<FloorPoint>> read_points(std::string_view text, const std::string& file) {
  const auto table = read_table(text, {"world_x", "world_y", "image_x", "image_y"}, "gvs.points", file);
  if (!table) return tl::unexpected(table.error());
  if (auto distinct = check_distinct(*table, 0, "this position on the floor", file); !distinct)
    return tl::unexpected(distinct.error());
  if (auto distinct = check_distinct(*table, 2, "this pixel", file); !distinct) return tl::unexpected(distinct.error());
  std::vector<FloorPoint> points;
  for (const Table::Row& row : table->rows)
    points.push_back({{row.numbers[0], row.numbers[1]}, {row.numbers[2], row.numbers[3]}});
  return points;
}

std::string write_points(const std::vector<FloorPoint>& points) {
  std::string text = "world_x; world_y; image_x; image_y;\n";
  for (const FloorPoint& point : points) {
    for (const double number : {point.floor.x_m, point.floor.y_m, point.pixel.u, point.pixel.v}) {
      JsonWriter json;  // its numbers read back to the same bits
      text += json.value(number).text() + "; ";
    }
    text.back() = '\n';
  }
  return text;
}

Result<std::vector<SurveyedPose>> read_poses(std::string_view text, const std::string& file) {
  const auto table =
      read_table(text, {"true_x", "true_y", "true_heading_deg", "detected_x", "detected_y", "detected_heading_deg"},
                 "gvs.poses", file);
  if (!table) return tl::unexpected(table.error());
  std::vector<SurveyedPose> poses;
  for (const auto& [line, n] : table->rows) {
    poses.push_back({{n[0], n[1], wrap_angle(n[2] * degree_rad)}, {n[3], n[4], wrap_angle(n[5] * degree_rad)}, 1, 0.0});
  }
  return poses;
}

Result<std::vector<SurveyedPose>> read_pose_stops(std::string_view text, const std::string& file, const PoseGrid& grid,
                                                  double leap) {
  Lines lines{text};
  std::string_view line;
  std::vector<Stop> stops;
  std::array<double, 4> before{};
  while (lines.next(line)) {
    line = trimmed(line);
    if (line.empty() || line.starts_with('#')) continue;
    const auto row = sample_of(line);
    if (!row) {
      return fail("gvs.poses", "expected 'x, y, cos, sin, weight' of finite numbers, found " + in_quotes(line),
                  location_of(file, lines.number()));
    }
    if (stops.empty() || between(*row, before) > leap) stops.emplace_back();
    stops.back().add(*row);
    before = *row;
  }
  const std::size_t expected = grid.xs_m.size() * grid.ys_m.size() * grid.headings_rad.size();
  if (stops.size() != expected || expected == 0) {
    return fail("gvs.poses",
                "shows " + std::to_string(stops.size()) + " poses, and the grid has " + std::to_string(expected) +
                    " poses (" + std::to_string(grid.ys_m.size()) + " y, " + std::to_string(grid.xs_m.size()) + " x, " +
                    std::to_string(grid.headings_rad.size()) + " headings)",
                file);
  }
  std::vector<SurveyedPose> poses;
  for (const double y : grid.ys_m)
    for (const double x : grid.xs_m)
      for (const double heading : grid.headings_rad)
        poses.push_back(stops[poses.size()].mean({x, y, wrap_angle(heading)}));
  return poses;
}

}  // namespace cosiva::vision
