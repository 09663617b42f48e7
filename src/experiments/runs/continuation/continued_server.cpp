#include "cosiva/experiments/runs/continuation/continued_server.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/typed_message.h"

namespace cosiva::experiments {
namespace {

struct Describe {
  std::string operator()(const wire::Publish& publish) const {
    return "publish " + publish.topic + " " + publish.payload + (publish.typed ? " (as values)" : "");
  }
  std::string operator()(const wire::SendBytes& send) const { return "bytes to " + send.port; }
  std::string operator()(const wire::Persist& persist) const { return "persist " + persist.bytes; }
  std::string operator()(const wire::Log& log) const { return "log " + log.text; }
  std::string operator()(const wire::Listen& listen) const {
    return "listen to " + std::to_string(listen.filters.size()) + " filters";
  }
};

std::string bytes_of(const std::shared_ptr<const wire::InProcessMessage>& message) {
  auto values = std::dynamic_pointer_cast<const wire::TypedMessage>(message);
  COSIVA_EXPECT(values || !message);
  std::string bytes;
  Archive archive{bytes};
  archive(values);
  return bytes;
}

/// Messages as values are equal where their contents are, wherever these are located.
bool equal(const wire::Effect& a, const wire::Effect& b) {
  const auto* published = std::get_if<wire::Publish>(&a);
  const auto* other = std::get_if<wire::Publish>(&b);
  if (published == nullptr || other == nullptr) return a == b;
  return published->topic == other->topic && published->payload == other->payload && published->qos == other->qos &&
         published->retained == other->retained && bytes_of(published->typed) == bytes_of(other->typed);
}

std::string text_of(const wire::Effects& effects, std::size_t index) {
  return index < effects.size() ? std::visit(Describe{}, effects[index]) : std::string{"nothing"};
}

}  // namespace

ContinuedServer::ContinuedServer(virtual_side::ServerOptions options)
    : server_{std::make_unique<virtual_side::ServerCore>(std::move(options))},
      runner_{std::make_unique<wire::CoreRunner>(*server_)} {}

Result<ContinuedServer> ContinuedServer::from(virtual_side::ServerOptions options, std::string_view snapshot,
                                              Digest history) {
  ContinuedServer continued{std::move(options)};
  if (auto taken = continued.server_->continue_from(snapshot); !taken) return tl::unexpected(taken.error());
  continued.runner_->continue_history(history);
  return continued;
}

void ContinuedServer::feed(const wire::Input& input, const wire::Effects& effects) {
  COSIVA_EXPECT(server_);
  const wire::Effects& own = runner_->feed(input);
  ++inputs_;
  if (difference_) return;
  const auto [first, other] = std::ranges::mismatch(own, effects, equal);
  if (first == own.end() && other == effects.end()) return;
  const auto index = static_cast<std::size_t>(first - own.begin());
  difference_ = "input " + std::to_string(inputs_) + " (" + input.source + " " + input.payload.substr(0, 200) +
                "): " + text_of(own, index) + "\n instead of " + text_of(effects, index);
}

}  // namespace cosiva::experiments
