#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cosiva::virtual_side {

/// One moving object as the page draws it; 20 bytes on the wire (docs/protocols/hmi-api.md, "Binary frames").
struct PositionRecord {
  enum class Kind : std::uint8_t { aiv = 0, person = 1, obstacle = 2 };
  std::uint16_t handle{};  ///< of the snapshot's "handle"
  Kind kind{Kind::aiv};
  std::uint8_t status{};  ///< 0 Normal, 1 stopped, 2 slow, 3 medium, 4 fast, 5 lost
  bool augmented{};
  bool blocked{};  ///< protective field violated, or braking for a virtual body
  float x_m{};
  float y_m{};
  float heading_rad{};
  float speed_mps{};
  float reported_dx_m{};  ///< from the twin to the last report
  float reported_dy_m{};
};

/// Makes binary frames of position records. A key frame holds all records; a delta holds those that differ from the
/// last key frame, so any one delta may be lost. A frame is encoded once for all clients.
///
/// Invariant: the last key frame has the handles of the last frame, sorted and each once, so that a delta can be
/// applied to it.
class PositionFrames {
 public:
  static constexpr std::size_t header_bytes = 24;
  static constexpr std::size_t record_bytes = 20;

  /// A key frame is made at least this often (in frames), and whenever a handle appeared or disappeared.
  explicit PositionFrames(std::uint32_t key_every = 30);

  struct Frame {
    std::string bytes;
    bool key;
  };
  /// Headings are wrapped into (−π, π]; a value outside its field's range is clamped, and a value that is not a number
  /// becomes 0.
  /// @param time_ms   of the server's clock, Unix milliseconds
  /// @param records   sorted by handle, each once (checked)
  [[nodiscard]] Frame encode(double time_ms, std::span<const PositionRecord> records);
  /// The next frame is a key frame.
  void request_key() { request_key_ = true; }

 private:
  using Record = std::array<char, record_bytes>;
  [[nodiscard]] bool same_handles_as_key() const;

  std::uint32_t key_every_;
  std::uint32_t sequence_{0};
  std::uint32_t key_sequence_{0};
  bool request_key_{true};
  // Encoded records: two records differ if their bytes do.
  std::vector<Record> key_;
  std::vector<Record> now_;
};

}  // namespace cosiva::virtual_side
