#include "cosiva/virtual/server/core/message_intake.h"

#include <string>
#include <string_view>

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::virtual_side {

void MessageIntake::receive(const wire::Input& input) {
  context_.link.on_message();
  if (input.source.starts_with(wire::v2x_topic_prefix)) return v2x_.receive(input);
  if (BatteryTestRelay::handles(input.source)) return on_battery(input);
  if (GroundTruthComparator::handles(input.source)) return on_gvs(input);
  if (CrossingUnits::handles(input.source)) return on_unit(input);
  if (ownership_.receive(input)) return;
  if (!augmented_.hosted.empty() && augmented_.hosted.from_broker(context_.now, input)) return;
  const std::size_t vehicles = context_.registry.size();
  if (reports_.receive(input)) return;
  COSIVA_EXPECT(context_.registry.size() == vehicles);
  if (input.source.starts_with(context_.topics.zone_prefix)) on_zone(input);
}

void MessageIntake::on_battery(const wire::Input& input) {
  // Shown in every control area: a battery can be changed anywhere.
  const auto news = instruments_.batteries.on_message(input);
  if (!news) return refuse_unknown_sender(context_, input.source, to_string(news.error()));
  if (!news->empty())
    context_.agents.battery_test.deliver(context_.traces, context_.now, {"battery", *news, input.source, input.payload},
                                         "*");
}

void MessageIntake::on_gvs(const wire::Input& input) {
  const auto news = instruments_.gvs.on_message(context_.now, input);
  if (!news) return refuse_unknown_sender(context_, input.source, to_string(news.error()));
  if (news->empty()) return context_.agents.gvs.deliver_untraced();
  context_.agents.gvs.deliver(context_.traces, context_.now, {"gvs", *news, input.source, input.payload});
}

void MessageIntake::on_unit(const wire::Input& input) {
  if (const auto taken = instruments_.units.on_message(context_.now, input); !taken)
    refuse_unknown_sender(context_, input.source, to_string(taken.error()));
}

void MessageIntake::on_zone(const wire::Input& input) {
  // An empty retained message clears a zone at the broker; the zone in force stays.
  if (input.payload.empty()) return;
  const std::string format = input.source.substr(context_.topics.zone_prefix.size());
  zones_.receive(zone::from_payload(format, input.source, input.payload),
                 input.flag ? ZoneSession::Source::retained : ZoneSession::Source::published);
}

}  // namespace cosiva::virtual_side
