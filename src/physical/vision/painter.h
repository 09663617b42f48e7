#pragma once

#include <cstdint>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/physical/vision/image.h"
#include "cosiva/physical/vision/scene.h"

namespace cosiva::vision {

/// Renders images. The same camera, lines, seed, bodies and number give the same bytes on every machine.
class Painter {
 public:
  Painter(const SceneCamera& camera, const std::vector<SceneLine>& lines, std::uint64_t seed);
  /// Row r is exposed from the stamp + r·line_s on, for exposure_s.
  /// @param number  of the image, for its noise
  [[nodiscard]] Image paint(const std::vector<SceneBody>& bodies, std::uint64_t number) const;
  [[nodiscard]] const SceneCamera& camera() const { return camera_; }

 private:
  struct Sighted {
    float x;
    float y;
  };
  void survey_neighbours();
  void draw_floor(const std::vector<SceneLine>& lines, std::uint64_t seed);
  void draw_body(const SceneBody& body, std::vector<float>& light) const;
  [[nodiscard]] Point2 detected_at(double u, double v) const;

  SceneCamera camera_;
  std::uint64_t seed_;
  std::vector<Sighted> corner_;  ///< the floor position of each pixel's upper left corner; one more than pixels
  std::vector<float> floor_;     ///< light of the bare floor, per pixel
  std::vector<float> noise_;     ///< generated once, and shuffled for each image
};

}  // namespace cosiva::vision
