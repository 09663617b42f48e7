#pragma once

#include <optional>
#include <vector>

#include "cosiva/zone/opendrive/easing.h"
#include "cosiva/zone/opendrive/model.h"

namespace cosiva::zone::opendrive {

/// A piecewise cubic over [from, to] of a road's s.
using Pieces = std::vector<Polynomial>;

/// Records that begin this near to each other, or to an end of their lane section, begin together: 5 cm, or a tenth of
/// the section. A shorter record is an artefact of the exporter.
[[nodiscard]] double nearness(double from, double to);
/// The file's records that hold between two values of s, the first from there on.
/// @param before  whether the first record's first value also holds before it; otherwise 0 does
[[nodiscard]] Pieces holding(std::vector<Polynomial> records, double from, double to, bool before);
/// a·left + b·right.
[[nodiscard]] Pieces sum(const Pieces& left, double a, const Pieces& right, double b, double near);
[[nodiscard]] const Polynomial& piece_at(const Pieces& pieces, double s);

/// The offset of a lane's centre line from the reference line: pieces whose jumps and kinks are smoothed.
class Lateral {
 public:
  /// Nothing where it jumps further than can be smoothed.
  [[nodiscard]] static std::optional<Lateral> make(Pieces pieces, double to);

  struct Value {
    double t;      ///< to the left
    double slope;  ///< by s
  };
  [[nodiscard]] Value at(double s) const;
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }
  [[nodiscard]] double greatest_jump() const { return jump_; }
  [[nodiscard]] double greatest_kink() const { return kink_; }

 private:
  Pieces pieces_;
  std::vector<double> ends_;
  std::vector<Easing> at_start_;
  std::vector<Easing> at_end_;
  std::vector<double> breaks_;
  double jump_{};
  double kink_{};
};

}  // namespace cosiva::zone::opendrive
