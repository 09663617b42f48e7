#include "cosiva/adapters/stop/stop_sender.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/loop_thread.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

using Targets = std::vector<wire::StopTarget>;
using Unconfirmed = std::map<std::string, std::vector<std::string>>;

/// How often in one resend period the pending Stops are examined.
constexpr int checks_per_resend = 10;

/// The listed vehicles of these names ("*": all); `all_listed` becomes false where one is not.
Targets chosen(const Targets& listed, const std::vector<std::string>& vehicles, bool& all_listed) {
  if (std::ranges::find(vehicles, "*") != vehicles.end()) return listed;
  Targets found;
  for (const std::string& name : vehicles) {
    const auto target = std::ranges::find(listed, name, &wire::StopTarget::name);
    if (target == listed.end())
      all_listed = false;
    else
      found.push_back(*target);
  }
  return found;
}

}  // namespace

struct StopSender::Impl {
  Impl(StopHandlers handlers_, PendingStops::Times times)
      : handlers{std::move(handlers_)},
        check_period{times.resend / checks_per_resend},
        pending{times},
        timer{thread.loop()} {}

  // --- the thread of the sender ----------------------------------------------------------------------------------

  MqttHandlers mqtt_handlers() {
    MqttHandlers made;
    made.on_link = [this](bool up) {
      connected = up;
      if (up) publish(pending.all(clock.now()));
    };
    made.on_message = [this](std::string_view topic, std::string_view payload, bool) {
      if (pending.on_state(topic, payload)) changed = true;
    };
    made.on_log = handlers.on_log;
    return made;
  }

  void publish(const PendingStops::Messages& messages) {
    COSIVA_EXPECT(thread.is_current());
    for (const wire::Publish& message : messages)
      if (mqtt->publish(message) && handlers.on_published) handlers.on_published(message);
  }

  void begin(const std::string& id, const Targets& targets) {
    publish(pending.begin(id, targets, clock.now()));
    // Only now, because these messages would delay the Stop.
    mqtt->listen(pending.state_topics());
    copy_unconfirmed();
    no_longer_queued(id);
    if (!pending.empty()) timer.every(check_period, [this] { check(); });
  }

  void check() {
    publish(pending.due(clock.now()));
    for (const PendingStops::Overdue& overdue : pending.take_overdue(clock.now()))
      if (handlers.on_log) handlers.on_log('w', "Stop " + overdue.id + " is not confirmed by " + overdue.vehicle);
    if (!std::exchange(changed, false)) return;
    copy_unconfirmed();
    if (!pending.empty()) return;
    timer.cancel();
    mqtt->listen({});
  }

  void copy_unconfirmed() {
    auto copy = std::make_shared<const Unconfirmed>(pending.unconfirmed());
    const std::lock_guard lock{mutex};
    unconfirmed = std::move(copy);
  }

  void no_longer_queued(const std::string& id) {
    const std::lock_guard lock{mutex};
    queued.erase(id);
  }

  StopHandlers handlers;
  std::chrono::nanoseconds check_period;
  WallClock clock;
  std::atomic<bool> connected{false};
  std::mutex mutex;  ///< of the three that follow
  std::shared_ptr<const Targets> listed{std::make_shared<const Targets>()};
  Unconfirmed queued;  ///< Stops that the thread has not begun
  std::shared_ptr<const Unconfirmed> unconfirmed{std::make_shared<const Unconfirmed>()};

  LoopThread thread;
  PendingStops pending;
  bool changed{false};  ///< since `unconfirmed` was copied
  Timer timer;
  std::unique_ptr<MqttClient> mqtt;
};

StopSender::StopSender() = default;
StopSender::~StopSender() {
  if (impl_) impl_->thread.stop();  // nothing else uses its objects from here on
}

Result<std::unique_ptr<StopSender>> StopSender::open(MqttOptions options, StopHandlers handlers,
                                                     PendingStops::Times times) {
  std::unique_ptr<StopSender> made{new StopSender};
  made->impl_ = std::make_unique<Impl>(std::move(handlers), times);
  Impl& impl = *made->impl_;
  auto mqtt = MqttClient::make(impl.thread.loop(), std::move(options), {}, std::nullopt, impl.mqtt_handlers());
  if (!mqtt) return tl::unexpected(mqtt.error());
  impl.mqtt = std::move(*mqtt);
  impl.thread.start(LoopThread::Priority::urgent);
  impl.thread.loop().post([&impl] { impl.mqtt->start(); });
  return made;
}

void StopSender::know(std::vector<wire::StopTarget> targets) {
  auto list = std::make_shared<const Targets>(std::move(targets));
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->listed = list;
  }
  impl_->thread.loop().post([impl = impl_.get(), list] {
    if (impl->pending.know(*list)) impl->changed = true;
  });
}

bool StopSender::send(const std::string& id, const std::vector<std::string>& vehicles) {
  bool all_listed = true;
  std::shared_ptr<const Targets> targets;
  {
    const std::lock_guard lock{impl_->mutex};
    targets = std::make_shared<const Targets>(chosen(*impl_->listed, vehicles, all_listed));
    for (const wire::StopTarget& target : *targets) impl_->queued[id].push_back(target.name);
  }
  if (!targets->empty()) impl_->thread.loop().post([impl = impl_.get(), id, targets] { impl->begin(id, *targets); });
  return all_listed;
}

void StopSender::lift(std::vector<std::string> vehicles) {
  impl_->thread.loop().post([impl = impl_.get(), vehicles = std::move(vehicles)] {
    if (impl->pending.lift(vehicles, impl->clock.now())) impl->changed = true;
  });
}

std::vector<std::string> StopSender::unconfirmed(const std::string& id) const {
  const std::lock_guard lock{impl_->mutex};
  if (const auto found = impl_->queued.find(id); found != impl_->queued.end()) return found->second;
  const auto found = impl_->unconfirmed->find(id);
  return found == impl_->unconfirmed->end() ? std::vector<std::string>{} : found->second;
}

bool StopSender::connected() const { return impl_->connected; }

}  // namespace cosiva::adapters
