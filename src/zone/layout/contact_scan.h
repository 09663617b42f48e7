#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/zone/circuit/followers.h"
#include "cosiva/zone/layout/contact_chunks.h"
#include "cosiva/zone/layout/contacts.h"

namespace cosiva::zone {

/// Scans stretches of one section, a body at every sample, and finds where it touches another section.
class ContactScan {
 public:
  ContactScan(const Circuit& circuit, const ContactRules& rules, const Chunks& chunks, const Followers& followers)
      : circuit_{circuit}, rules_{rules}, chunks_{chunks}, followers_{followers}, steps_per_m_{1.0 / rules.step_m} {}

  /// Two chunks that lie near each other.
  struct Pair {
    SectionId other;  ///< the section of `theirs`
    std::uint32_t mine;
    std::uint32_t theirs;
    friend bool operator==(const Pair&, const Pair&) = default;
    friend bool operator<(const Pair& a, const Pair& b) {
      return std::tie(a.other, a.mine, a.theirs) < std::tie(b.other, b.mine, b.theirs);
    }
  };
  /// Contacts of bodies on `on` with vehicles on `other`. The pairs are of chunks of these two, at least one, sorted.
  void along(SectionId on, SectionId other, std::span<const Pair> pairs);
  /// Contacts, in both directions, of bodies on `on` with a vehicle that turns on the spot at the end of `turning`.
  /// `near`: chunks of `on`, at least one, sorted.
  void turn(SectionId on, SectionId turning, std::span<const std::uint32_t> near);

  /// All found since.
  std::vector<Contact> contacts;

 private:
  /// A sample of a centre line.
  struct Sample {
    double s_m;
    Point2 p;
    std::size_t more;  ///< how many follow that are each at most a step from the one before
  };
  /// Samples of some chunks of one section, in their order.
  struct Line {
    struct Part {
      std::uint32_t chunk;
      std::size_t first;  ///< of its samples
    };
    std::vector<Sample> samples;
    std::vector<Part> parts;
  };
  /// A vehicle's body at s.
  struct Body {
    double s_m;
    Point2 p;
    double heading_rad;
    SinCos direction;
  };
  /// The parameters of one scan.
  struct Task {
    SectionId on;
    SectionId other;
    double near_m;  ///< a body's edge this near to a sample touches it
    // Those that follow each other do not touch.
    bool may_follow;
    double ahead_gap_m;   ///< from the end of `on` to the start of `other`
    double behind_gap_m;  ///< from the end of `other` to the start of `on`
  };

  [[nodiscard]] bool follow_each_other(const Task& task, double s_m, double other_s_m) const;
  [[nodiscard]] double beyond_square(const Body& body, Point2 p) const;
  [[nodiscard]] std::size_t steps_between(double far_m, double near_m) const;
  [[nodiscard]] bool touches(const Task& task, double s_m, const Line& line) const;
  bool grow(Contact& contact, double& nearest_square, const Task& task, const Body& body, const Line& line) const;
  [[nodiscard]] double boundary(const Task& task, double outside_m, double inside_m, const Line& line) const;
  void scan(const Task& task);

  void sample(const Chunk& chunk, std::vector<Sample>& samples) const;
  void lay_line(std::uint32_t mine);
  [[nodiscard]] Body body_at(SectionId on, double s_m, const Body* near) const;
  void sweep_along(const Chunk& chunk);

  const Circuit& circuit_;
  const ContactRules& rules_;
  const Chunks& chunks_;
  const Followers& followers_;
  double steps_per_m_;
  // Of the present scan; members, so that their memory is reused.
  std::vector<std::uint32_t> mine_;  ///< the chunks to scan
  std::span<const Pair> pairs_;      ///< the chunks near them, unless the line stays the same
  std::vector<Body> bodies_;
  Line line_;         ///< near the present chunk
  Line line_before_;  ///< near the one before
};

}  // namespace cosiva::zone
