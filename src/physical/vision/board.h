#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/physical/vision/points.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::vision {

/// A tag on the floor at a known position: a printed board consists of many of them.
struct BoardTag {
  int id{};
  Pose2 X_MT{};     ///< of its centre; x to its printed right
  double side_m{};  ///< of the black square
};

/// A CSV file with the columns id, x, y [m], heading_deg, side [m]. Fails ("gvs.board") as read_points does, on ids
/// that are not in the family, on duplicate ids, and on invalid sides.
[[nodiscard]] Result<std::vector<BoardTag>> read_board(std::string_view text, const std::string& file);
[[nodiscard]] std::string write_board(const std::vector<BoardTag>& board);

/// Reads a board's corners from images of a camera that does not move. Invariant: a sum has at least one image.
class BoardReader {
 public:
  explicit BoardReader(const std::vector<BoardTag>& board);
  /// Fails ("gvs.board") on an image of another size than the first, and on one that shows none of the board's tags.
  [[nodiscard]] Result<void> add(const Image& image);
  [[nodiscard]] ImageSize frame() const { return image_; }
  /// Corners, each the mean over the images that showed its tag.
  [[nodiscard]] std::vector<FloorPoint> points() const;

 private:
  struct Sum {
    std::array<PixelPoint, 4> corners{};
    double count{0.0};
  };
  std::vector<BoardTag> board_;
  ImageSize image_;
  std::map<int, Sum> sums_;
  TagFinder finder_;
};

}  // namespace cosiva::vision
