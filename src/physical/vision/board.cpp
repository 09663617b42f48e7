#include "cosiva/physical/vision/board.h"

#include <cmath>
#include <set>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/vision/table.h"

namespace cosiva::vision {

Result<std::vector<BoardTag>> read_board(std::string_view text, const std::string& file) {
  const auto table = read_table(text, {"id", "x", "y", "heading_deg", "side"}, "gvs.board", file);
  if (!table) return tl::unexpected(table.error());
  std::vector<BoardTag> board;
  std::set<int> ids;
  for (const auto& [line, n] : table->rows) {
    const std::string location = file + ":" + std::to_string(line);
    if (!(n[0] >= 0.0 && n[0] < tags_in_family) || n[0] != std::floor(n[0]))
      return fail("gvs.board", "family 36h11 has the tags 0 to " + std::to_string(tags_in_family - 1), location);
    if (!ids.insert(static_cast<int>(n[0])).second) return fail("gvs.board", "this tag occurs here twice", location);
    if (!(n[4] > 0.0)) return fail("gvs.board", "a tag's side is more than 0 m", location);
    board.push_back({static_cast<int>(n[0]), {n[1], n[2], wrap_angle(n[3] * pi / 180.0)}, n[4]});
  }
  return board;
}

std::string write_board(const std::vector<BoardTag>& board) {
  std::string text = "id; x; y; heading_deg; side\n";
  for (const BoardTag& tag : board) {
    text += std::to_string(tag.id);
    for (const double number : {tag.X_MT.x_m, tag.X_MT.y_m, tag.X_MT.heading_rad * 180.0 / pi, tag.side_m}) {
      JsonWriter json;
      text += "; " + json.value(number).text();
    }
    text += "\n";
  }
  return text;
}

BoardReader::BoardReader(const std::vector<BoardTag>& board) : board_{board} {}

Result<void> BoardReader::add(const Image& image) {
  if (image_ == ImageSize{}) image_ = image.size;
  if (image.size != image_) return fail("gvs.board", "is of another size than the first image");
  bool any = false;
  std::set<int> detected;
  for (const DetectedTag& tag : finder_.find(image, {})) {
    bool of_board = false;
    for (const BoardTag& one : board_) of_board = of_board || one.id == tag.id;
    if (!of_board || !detected.insert(tag.id).second) continue;
    Sum& sum = sums_[tag.id];
    for (std::size_t i = 0; i < 4; ++i) {
      sum.corners[i].u += tag.corners[i].u;
      sum.corners[i].v += tag.corners[i].v;
    }
    sum.count += 1.0;
    any = true;
  }
  if (!any) return fail("gvs.board", "shows none of the board's tags");
  return {};
}

std::vector<FloorPoint> BoardReader::points() const {
  std::vector<FloorPoint> points;
  for (const BoardTag& tag : board_) {
    const auto found = sums_.find(tag.id);
    if (found == sums_.end()) continue;
    constexpr std::array<Point2, 4> square{Point2{-0.5, -0.5}, Point2{0.5, -0.5}, Point2{0.5, 0.5}, Point2{-0.5, 0.5}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Point2 floor = tag.X_MT * Point2{square[i].x_m * tag.side_m, square[i].y_m * tag.side_m};
      COSIVA_EXPECT(found->second.count > 0.0);
      const PixelPoint& sum = found->second.corners[i];
      points.push_back({floor, {sum.u / found->second.count, sum.v / found->second.count}});
    }
  }
  return points;
}

}  // namespace cosiva::vision
