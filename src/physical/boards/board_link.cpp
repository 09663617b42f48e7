#include "cosiva/physical/boards/board_link.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

/// Replaces the firmware hash of a real board: the version name of this build.
std::uint32_t firmware_hash(wire::Board board) {
  Digest digest;
  digest.add(std::string_view{"emulated board 1"});
  digest.add(to_string(board));
  return static_cast<std::uint32_t>(digest.value() >> 32U);
}

}  // namespace

bool Every::take(SimTime now) {
  if (!due(now)) return false;
  next_ += period_;
  if (next_ <= now) next_ = now + period_;
  COSIVA_EXPECT(!due(now));
  return true;
}

BoardLink::BoardLink(wire::Board board) : board_{board} {}

void BoardLink::power_up(SimTime now, std::uint32_t session) {
  powered_at_ = now;
  session_ = session;
  hello_due_ = true;
  self_test_due_.reset();
  fault_ = 0;
  heartbeat_.start(now);
}

void BoardLink::connect(bool up) {
  connected_ = up;
  fresh_ = up;
  hello_due_ = up;
  decoder_.restart();
}

void BoardOutput::put_delimiter() const {
  if (bytes_ != nullptr) bytes_->push_back('\0');
}

void BoardOutput::put(wire::Board board, wire::module_link::Encoder& encoder, const wire::BoardMessage& message) const {
  COSIVA_EXPECT((bytes_ == nullptr) != (values_ == nullptr));
  if (bytes_ != nullptr) return encoder.append(*bytes_, message);
  values_->add(board, encoder.next_sequence(), message);
}

const std::vector<wire::BoardMessage>& BoardLink::receive(std::string_view bytes) {
  received_.clear();
  decoder_.feed(bytes, received_);
  for (const auto& message : received_) take_request(message);
  return received_;
}

void BoardLink::receive(const wire::BoardFrames::Frame& frame) {
  COSIVA_EXPECT(frame.board == board_);
  decoder_.count(frame.sequence, frame.message);
  take_request(frame.message);
}

void BoardLink::take_request(const wire::BoardMessage& message) {
  hello_due_ = hello_due_ || std::holds_alternative<wire::Hello>(message);
  if (const auto* request = std::get_if<wire::SelfTestRequest>(&message)) self_test_due_ = request->number;
}

void BoardLink::finish_self_test(std::uint8_t number, std::vector<wire::PartFinding> parts, BoardOutput out) {
  fault_ = 0;
  for (const wire::PartFinding& part : parts) report_fault(part);
  send(wire::SelfTestResult{number, std::move(parts)}, out);
}

void BoardLink::report_fault(wire::PartFinding fault) {
  if (fault_ == 0) fault_ = wire::fault_code(fault);
}

void BoardLink::tick(SimTime now, BoardOutput out) {
  const bool heartbeat = heartbeat_.take(now);
  COSIVA_EXPECT(connected_ || !fresh_);
  if (!connected_) return;
  // The line's content from before the connection must not run into the first frame.
  if (fresh_) out.put_delimiter();
  fresh_ = false;
  if (hello_due_) send(wire::Hello{board_, wire::module_link::version, firmware_hash(board_), session_}, out);
  hello_due_ = false;
  if (heartbeat) {
    const auto& counters = decoder_.counters();
    send(wire::Heartbeat{board_ms(now), counters.frames_bad, counters.frames_missed, fault_}, out);
  }
}

void BoardLink::send(const wire::BoardMessage& message, BoardOutput out) {
  if (connected_) out.put(board_, encoder_, message);
}

std::uint32_t BoardLink::board_ms(SimTime now) const {
  return static_cast<std::uint32_t>((now - powered_at_) / std::chrono::milliseconds{1});
}

void BoardLink::archive(Archive& archive) { archive(powered_at_, session_, fault_); }

}  // namespace cosiva::physical
