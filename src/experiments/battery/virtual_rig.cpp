#include "cosiva/experiments/battery/virtual_rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/experiments/battery/load_profile.h"
#include "cosiva/experiments/battery/record_json.h"

namespace cosiva::experiments {
namespace {

constexpr int steps_a_minute = 600;
constexpr SimDuration step_time = std::chrono::milliseconds{100};

tl::unexpected<Error> bad(std::string what) { return fail("battery.state", std::move(what), "saved state"); }

}  // namespace

struct VirtualRig::Impl {
  /// A vehicle on the circuit: its monitor, and the gauge that estimates the charge of the present battery.
  struct Cart {
    battery::Monitor monitor;
    battery::Gauge gauge;
    double load_factor;
    double least_w;     ///< at standstill, in a pause
    std::size_t at{0};  ///< index in its profile
    double distance_m{0.0};
    double fails_after_s{std::numeric_limits<double>::infinity()};
    bool paused{false};
    TrueEnd ground_truth{};
  };

  VirtualRigOptions options;
  std::vector<LoadProfile> loads;
  std::shared_ptr<const battery::CellTable> table;
  Procedure procedure;
  std::vector<battery::Pack> packs;  ///< by battery
  std::vector<Cart> carts;
  SimTime now{virtual_epoch};
  std::uint64_t minutes{0};
  std::vector<TrueEnd> ends;
  std::vector<std::string> operator_messages;
  ProcedureCommands changes;  ///< requested, to be done before the next run

  Impl(VirtualRigOptions o, std::vector<LoadProfile> l)
      : options{std::move(o)},
        loads{std::move(l)},
        table{std::make_shared<battery::CellTable>(options.battery.type)},
        procedure{options.procedure} {
    COSIVA_EXPECT(loads.size() == options.procedure.vehicles);
    const BatteryUnderTest& kind = options.battery;
    for (std::size_t b = 0; b < loads.size(); ++b) {
      const std::string id = kind.type.name + "-" + std::to_string(b + 1);
      packs.emplace_back(table, kind.design, battery::PackHistory{id, options.seed * 1000 + b, kind.spread, 0.0},
                         kind.ambient_c);
    }
    for (std::size_t v = 0; v < loads.size(); ++v) {
      COSIVA_EXPECT(!loads[v].power_w.empty());
      Random random = stream("cart", v);
      const double factor = std::max(0.5, 1.0 + random.gaussian(0.0, options.load_sd));
      carts.push_back({battery::Monitor{{}, stream("monitor", v)}, fresh_gauge(), factor,
                       *std::ranges::min_element(loads[v].power_w)});
    }
    obey(procedure.start(now));
    change_batteries(SimDuration::zero());
  }

  [[nodiscard]] Random stream(const char* purpose, std::size_t vehicle) const {
    return {options.seed, "battery/" + std::string(purpose) + "/" + std::to_string(vehicle)};
  }
  [[nodiscard]] battery::Gauge fresh_gauge() const {
    return {table, {options.battery.gauge, options.battery.design, {}, options.battery.type.capacity_spread}};
  }
  [[nodiscard]] battery::Pack& pack_of(std::size_t vehicle) {
    return packs[procedure.battery_of(procedure.run(), vehicle)];
  }

  void obey(const ProcedureCommands& commands) {
    for (const ProcedureCommand& command : commands) {
      using Kind = ProcedureCommand::Kind;
      switch (command.kind) {
        case Kind::change_battery: changes.push_back(command); break;
        case Kind::notify_operator: operator_messages.push_back(command.text); break;
        case Kind::run: begin(command.vehicle); break;
        case Kind::pause: carts[command.vehicle].paused = true; break;
        case Kind::resume: carts[command.vehicle].paused = false; break;
        case Kind::stop: break;  // the cart leaves the circuit, and its battery rests
      }
    }
  }

  void begin(std::size_t v) {
    Cart& cart = carts[v];
    cart.paused = false;
    cart.ground_truth = {procedure.run(), v, to_seconds(now - virtual_epoch), 1.0, pack_of(v).capacity_ah(), {}, {}};
    // Each run has its own failure times, independent of the other runs.
    Random random = stream("fate", v * 1000 + procedure.run());
    const double hours = -det_log(1.0 - random.uniform());
    if (options.failures_per_hour > 0.0) cart.fails_after_s = 3600.0 * hours / options.failures_per_hour;
  }

  /// Inserts the requested batteries, charged and rested: each vehicle reports ready.
  void change_batteries(SimDuration service) {
    if (changes.empty()) return;
    now += service;
    for (const ProcedureCommand& change : std::exchange(changes, {})) {
      battery::Pack& pack = packs[change.battery];
      pack.renew(options.battery.ambient_c);
      Cart& cart = carts[change.vehicle];
      cart.gauge.full();
      cart.monitor.renew_noise(stream("change", change.vehicle * 1000 + procedure.run()));
      const battery::Measured detected = cart.monitor.measure(pack.voltage_v(), 0.0, pack.temperature_c());
      obey(procedure.on_ready(now, change.vehicle,
                              {pack.history().id, options.battery.type.name, pack.cycles(), to_seconds(service),
                               detected.temperature_c, cart.gauge.reading().charge}));
    }
  }

  /// Runs one vehicle for a minute, or until it is stopped.
  void drive(std::size_t v) {
    Cart& cart = carts[v];
    const LoadProfile& load = loads[v];
    cart.monitor.renew_noise({options.seed, "battery/noise/" + std::to_string(v) + "/" + std::to_string(minutes)});
    const std::size_t run = procedure.run();
    for (int i = 1; i <= steps_a_minute && procedure.run() == run && procedure.running(v); ++i) {
      battery::Pack& pack = pack_of(v);
      const SimTime at = now + i * step_time;
      const double power_w = cart.load_factor * (cart.paused ? cart.least_w : load.power_w[cart.at]);
      if (!cart.paused) {
        cart.distance_m += load.moved_m[cart.at];
        if (++cart.at == load.power_w.size()) cart.at = 0;
      }
      const battery::PackStep step = pack.draw_power(power_w, options.battery.ambient_c, load_step_s);
      const battery::Measured detected = cart.monitor.measure(step.voltage_v, step.current_a, pack.temperature_c());
      cart.gauge.see(detected, load_step_s);
      const battery::GaugeReading reading = cart.gauge.reading();
      record_ground_truth(cart, pack, to_seconds(at - virtual_epoch) - cart.ground_truth.started_s);
      const auto commands = procedure.on_sample(v, {at, reading.charge, reading.charge_sd, detected.voltage_v,
                                                    detected.current_a, detected.temperature_c, cart.distance_m});
      obey(commands);
      if (procedure.run() != run || !procedure.running(v)) break;
      if (step.event != battery::PackEvent::none) obey(procedure.on_stop(at, v, StopCause::cut_off));
      cart.fails_after_s -= load_step_s;
      if (cart.fails_after_s <= 0.0) obey(procedure.on_stop(at, v, StopCause::fault));
    }
    if (procedure.run() == run && procedure.running(v)) return;
    cart.ground_truth.charge = packs[procedure.battery_of(run, v)].charge();
    ends.push_back(cart.ground_truth);
  }

  void record_ground_truth(Cart& cart, const battery::Pack& pack, double at_s) const {
    const double every_s = to_seconds(options.procedure.curve_every);
    if (!cart.ground_truth.curve_s.empty() && at_s - cart.ground_truth.curve_s.back() < every_s - 1e-6) return;
    cart.ground_truth.curve_s.push_back(at_s);
    cart.ground_truth.curve_charge.push_back(pack.charge());
  }

  void step() {
    const std::size_t run = procedure.run();
    for (std::size_t v = 0; v < carts.size() && procedure.run() == run; ++v)
      if (procedure.running(v)) drive(v);
    ++minutes;
    now += std::chrono::minutes{1};
    change_batteries(options.service);
  }
};

VirtualRig::VirtualRig(VirtualRigOptions options, std::vector<LoadProfile> loads)
    : impl_{std::make_unique<Impl>(std::move(options), std::move(loads))} {}
VirtualRig::~VirtualRig() = default;
VirtualRig::VirtualRig(VirtualRig&&) noexcept = default;
VirtualRig& VirtualRig::operator=(VirtualRig&&) noexcept = default;

void VirtualRig::step() {
  if (!done()) impl_->step();
}
bool VirtualRig::done() const { return impl_->procedure.done(); }
SimTime VirtualRig::now() const { return impl_->now; }
const Procedure& VirtualRig::procedure() const { return impl_->procedure; }
const std::vector<TrueEnd>& VirtualRig::ground_truth() const { return impl_->ends; }
std::vector<std::string> VirtualRig::take_messages() { return std::exchange(impl_->operator_messages, {}); }

namespace {

void write_ground_truth(JsonWriter& json, const TrueEnd& ground_truth) {
  json.begin_object()
      .field("run", ground_truth.run)
      .field("vehicle", ground_truth.vehicle)
      .field("charge", ground_truth.charge);
  json.field("started_s", ground_truth.started_s)
      .field("capacity_ah", ground_truth.capacity_ah)
      .key("curve_s")
      .begin_array();
  for (const double value : ground_truth.curve_s) json.value(value);
  json.end_array().key("curve_charge").begin_array();
  for (const double value : ground_truth.curve_charge) json.value(value);
  json.end_array().end_object();
}

Result<TrueEnd> read_ground_truth(const JsonValue& json) {
  TrueEnd ground_truth{};
  ground_truth.run = static_cast<std::size_t>(std::max(0.0, json.number("run").value_or(0.0)));
  ground_truth.vehicle = static_cast<std::size_t>(std::max(0.0, json.number("vehicle").value_or(0.0)));
  ground_truth.charge = json.number("charge").value_or(0.0);
  ground_truth.started_s = json.number("started_s").value_or(0.0);
  ground_truth.capacity_ah = json.number("capacity_ah").value_or(0.0);
  for (const auto& [key, target] :
       {std::pair{"curve_s", &ground_truth.curve_s}, std::pair{"curve_charge", &ground_truth.curve_charge}}) {
    const JsonValue* list = json.find(key);
    if (list == nullptr || list->array() == nullptr) return bad("a true curve is missing");
    for (const JsonValue& item : *list->array()) {
      if (item.number() == nullptr) return bad("a true curve holds something else than numbers");
      target->push_back(*item.number());
    }
  }
  return ground_truth;
}

}  // namespace

std::string VirtualRig::state_json() const {
  const Impl& in = *impl_;
  JsonWriter json;
  json.begin_object().field("format", "cosiva-battery-test/1").field("seed", std::to_string(in.options.seed));
  json.field("type", in.options.battery.type.name).field("minutes", in.minutes);
  json.field("now_s", to_seconds(in.now - virtual_epoch)).key("procedure").raw(in.procedure.state_json());
  json.key("packs").begin_array();
  for (const battery::Pack& pack : in.packs) json.raw(pack.state_json());
  json.end_array().key("carts").begin_array();
  for (const Impl::Cart& cart : in.carts) {
    json.begin_object().key("gauge").raw(cart.gauge.state_json()).field("at", cart.at);
    json.field("distance_m", cart.distance_m).field("paused", cart.paused).key("fails_after_s");
    json.value(cart.fails_after_s).key("ground_truth");  // infinity becomes null
    write_ground_truth(json, cart.ground_truth);
    json.end_object();
  }
  json.end_array().key("ends").begin_array();
  for (const TrueEnd& end : in.ends) write_ground_truth(json, end);
  return json.end_array().end_object().take();
}

Result<void> VirtualRig::restore(std::string_view state_json) {
  constexpr std::size_t bytes_max = 512U << 20U;
  const auto json = JsonValue::parse(state_json, bytes_max);
  if (!json) return bad(json.error().message);
  Impl& in = *impl_;
  if (json->text("format") != "cosiva-battery-test/1") return bad("the state is of no battery test");
  if (json->text("seed") != std::to_string(in.options.seed) || json->text("type") != in.options.battery.type.name)
    return bad("the state is of another test: its seed or type differs");
  const JsonValue* procedure = json->find("procedure");
  const JsonValue* packs = json->find("packs");
  const JsonValue* carts = json->find("carts");
  const JsonValue* ends = json->find("ends");
  for (const JsonValue* list : {packs, carts, ends})
    if (list == nullptr || list->array() == nullptr) return bad("the state is not complete");
  if (procedure == nullptr || packs->array()->size() != in.packs.size() || carts->array()->size() != in.carts.size())
    return bad("the state is not complete");
  if (auto done = in.procedure.restore(to_text(*procedure)); !done) return done;
  for (std::size_t b = 0; b < in.packs.size(); ++b)
    if (auto done = in.packs[b].restore(to_text((*packs->array())[b])); !done) return done;
  for (std::size_t v = 0; v < in.carts.size(); ++v) {
    const JsonValue& saved = (*carts->array())[v];
    Impl::Cart& cart = in.carts[v];
    const JsonValue* gauge = saved.find("gauge");
    const JsonValue* ground_truth = saved.find("ground_truth");
    const auto at = saved.number("at");
    if (gauge == nullptr || ground_truth == nullptr || !at ||
        !(*at >= 0.0 && *at < static_cast<double>(in.loads[v].power_w.size())))
      return bad("a vehicle's state is not complete");
    if (auto done = cart.gauge.restore(to_text(*gauge)); !done) return done;
    auto read = read_ground_truth(*ground_truth);
    if (!read) return tl::unexpected(read.error());
    cart.ground_truth = std::move(*read);
    cart.at = static_cast<std::size_t>(*at);
    cart.distance_m = saved.number("distance_m").value_or(0.0);
    cart.paused = saved.flag("paused").value_or(false);
    cart.fails_after_s = saved.number("fails_after_s").value_or(std::numeric_limits<double>::infinity());
  }
  in.ends.clear();
  for (const JsonValue& item : *ends->array()) {
    auto end = read_ground_truth(item);
    if (!end) return tl::unexpected(end.error());
    in.ends.push_back(std::move(*end));
  }
  in.minutes = static_cast<std::uint64_t>(std::max(0.0, json->number("minutes").value_or(0.0)));
  in.now = virtual_epoch + from_seconds(json->number("now_s").value_or(0.0));
  return {};
}

}  // namespace cosiva::experiments
