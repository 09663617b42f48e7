#include "cosiva/app/gvs/gvs_watch_command.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/gvs/actual_positions.h"
#include "cosiva/app/gvs/camera_pipeline.h"
#include "cosiva/app/gvs/gvs_scene.h"
#include "cosiva/app/gvs/gvs_source_files.h"
#include "cosiva/app/gvs/preview_feed.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/vision/calibration_json.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;

/// A preview request comes twice per second while a client displays the preview.
constexpr SimDuration looked_for{std::chrono::seconds{2}};
/// An emulated world without messages for this time is treated as absent.
constexpr SimDuration ground_truth_missed_after{std::chrono::seconds{2}};

std::string text_of(const GvsSource& source) {
  if (!source.images_folder.empty()) return "the images of " + source.images_folder;
  if (!source.video_file.empty()) return "the video " + source.video_file;
  return "the camera /dev/video" + std::to_string(source.camera.value_or(0));
}

class Watch {
 public:
  Watch(const GvsWatchArguments& arguments, std::map<int, std::string> names)
      : arguments_{arguments},
        source_{arguments.source},
        names_{std::move(names)},
        text_{source_.emulated() ? "the emulated world's camera" : text_of(source_)},
        heartbeat_{loop_},
        duration_{loop_} {}

  int run(std::optional<vision::Calibration> calibration) {
    if (calibration) camera_.emplace(std::move(*calibration), tracker_options(source_), names_);
    if (auto connected = connect(); !connected) return report_error(connected.error());
    loop_.on_signals({SIGINT, SIGTERM, SIGHUP}, [this](int) {
      if (std::exchange(interrupted_, true))
        return loop_.stop();  // second signal: end at once, without a final message
      end();
    });
    if (arguments_.part.duration_s) duration_.after(from_seconds(*arguments_.part.duration_s), [this] { end(); });
    // A zone without ground truth is not the emulated world.
    ground_truth_received_ = clock_.now();
    heartbeat_.every(milliseconds{500}, [this] { check_for_ground_truth(); });
    if (!source_.emulated()) open_feed();
    client_->start();
    loop_.run();
    feed_.reset();
    if (arguments_.part.json) print(json());
    // The run's own check: a watch without any detection proves nothing.
    return counts_.detected == 0 && !interrupted_ ? exit_check_failed : exit_done;
  }

 private:
  Result<void> connect() {
    auto options = mqtt_options(arguments_.part.broker, "cosiva-gvs");
    if (!options) return tl::unexpected(options.error());
    adapters::MqttHandlers handlers;
    handlers.on_link = [this](bool up) {
      if (up) publish_connection(wire::ConnectionState::online);
    };
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool) { receive(topic, payload); };
    std::vector<std::string> topics{std::string(wire::gvs_preview_request_topic),
                                    wire::topics_below(wire::gvs_position_request_topic_prefix, 2),
                                    wire::topics_below(wire::zone_topic_prefix, 1)};
    if (source_.emulated()) topics.emplace_back(wire::ground_truth_topic);
    const wire::Will will{
        {std::string(wire::gvs_connection_topic),
         to_json(wire::GvsConnection{wire::ConnectionState::connection_broken, clock_.now(), text_, {}}), 1, true}};
    auto client = adapters::MqttClient::make(loop_, std::move(*options), std::move(topics), will, std::move(handlers));
    if (!client) return tl::unexpected(client.error());
    client_ = std::move(*client);
    return {};
  }

  void open_feed() {
    PreviewFeed::Options options;
    options.open = [source = source_] { return open_images(source); };
    options.recorded = !source_.camera.has_value();
    options.rate_hz = source_.rate_hz;
    feed_ = std::make_unique<PreviewFeed>(
        loop_, std::move(options),
        PreviewFeed::Handlers{[this](const Frame& frame, SimTime began) { take(frame.image, began); },
                              [this](const std::string& why) { set_trouble(why); }});
  }

  void receive(std::string_view topic, std::string_view payload) {
    if (topic == wire::gvs_preview_request_topic) {
      looked_until_ = clock_.now() + looked_for;
    } else if (const auto vehicle = wire::parse_own_topic(wire::gvs_position_request_topic_prefix, topic)) {
      positions_.on_request(clock_.now(), *vehicle, payload);
    } else if (topic == wire::ground_truth_topic) {
      if (auto ground_truth = read_plant_ground_truth(std::string(payload))) see_world(std::move(*ground_truth));
    } else if (topic.starts_with(wire::zone_topic_prefix) && !payload.empty()) {
      take_zone(std::string(topic), payload);
    }
  }

  /// The zone defines the vehicles' size, and the scene of an emulated camera.
  void take_zone(const std::string& topic, std::string_view payload) {
    const auto configuration = zone::from_payload(topic.substr(wire::zone_topic_prefix.size()), topic, payload);
    if (zone_ && same_content(*zone_, configuration)) return;
    const auto rtm = zone::Rtm::initialise(configuration);
    if (!rtm) return;  // the server reports the error; the present zone stays
    zone_ = configuration;
    body_ = rtm->zone().vehicle;
    if (!source_.emulated()) return;
    auto camera = EmulatedCamera::over(rtm->zone());
    if (!camera) return set_trouble(to_string(camera.error()));
    emulated_ = std::move(*camera);
    text_ = "the emulated world's camera over " + decimals(emulated_->width_m(), 1) + " m of " + rtm->zone().name;
    GvsSource known = source_;
    known.exposure_ms = 1e3 * emulated_->exposure_s();
    known.tag_side_m = emulated_->tag_side_m();
    camera_.emplace(emulated_->calibration(), tracker_options(known), names_);
    publish_connection(wire::ConnectionState::online);
  }

  void see_world(GroundTruth ground_truth) {
    ground_truth_received_ = clock_.now();
    if (emulated_ && ground_truth.at >= due_) {
      const SimDuration period = from_seconds(1.0 / source_.rate_hz);
      due_ = std::max(due_ + period, ground_truth.at + period / 2);
      take(emulated_->take(ground_truth, ground_truth_), ground_truth.at);
    }
    ground_truth_ = std::move(ground_truth);
  }

  void check_for_ground_truth() {
    if (source_.emulated() && clock_.now() - ground_truth_received_ > ground_truth_missed_after)
      set_trouble("the emulated world (cosiva plant) sends nothing");
  }

  void take(const vision::Image& image, SimTime began) {
    if (!camera_) return;
    const auto detections = camera_->see(image, began, 1.0 / source_.rate_hz);
    if (!detections) return set_trouble(to_string(detections.error()));
    set_trouble({});
    ++counts_.images;
    counts_.detected += detections->detections.size();
    client_->publish({std::string(wire::gvs_detections_topic), to_json(*detections), 0, false});
    for (const wire::Publish& response : positions_.on_detections(*detections)) client_->publish(response);
    if (clock_.now() <= looked_until_)
      client_->publish({std::string(wire::gvs_preview_topic), camera_->shown(image, *detections, body_), 0, false});
  }

  void set_trouble(const std::string& why) {
    if (why == trouble_) return;
    trouble_ = why;
    print_info(why.empty() ? "cosiva gvs: images arrive" : "cosiva gvs: " + why);
    publish_connection(wire::ConnectionState::online);
  }

  void publish_connection(wire::ConnectionState state) {
    client_->publish({std::string(wire::gvs_connection_topic),
                      to_json(wire::GvsConnection{state, clock_.now(), text_, trouble_}), 1, true});
  }

  void end() {
    publish_connection(wire::ConnectionState::offline);
    client_->stop([this] { loop_.stop(); });
  }

  [[nodiscard]] std::string json() const {
    JsonWriter json;
    json.begin_object().field("source", text_).field("images", counts_.images).field("fixes", counts_.detected);
    json.field("trouble", trouble_).end_object();
    return json.take();
  }

  const GvsWatchArguments& arguments_;
  const GvsSource& source_;
  std::map<int, std::string> names_;
  std::string text_;
  std::string trouble_;
  adapters::EventLoop loop_;
  adapters::WallClock clock_;
  std::unique_ptr<adapters::MqttClient> client_;
  adapters::Timer heartbeat_;
  adapters::Timer duration_;
  std::optional<GvsCamera> camera_;
  ActualPositions positions_;
  std::optional<zone::ZoneConfiguration> zone_;
  zone::VehicleShape body_;
  std::optional<EmulatedCamera> emulated_;
  std::optional<GroundTruth> ground_truth_;
  SimTime ground_truth_received_{};
  SimTime due_{};
  SimTime looked_until_{};
  struct Counts {
    std::uint64_t images{0};
    std::uint64_t detected{0};
  };
  Counts counts_;
  bool interrupted_{false};
  std::unique_ptr<PreviewFeed> feed_;
};

}  // namespace

int run_gvs_watch(const GvsWatchArguments& arguments) {
  const GvsSource& source = arguments.source;
  // `up` has checked the source before; a camera that is absent at this moment may come back.
  if (!arguments.part.announce) {
    if (auto checked = check_gvs_source(source, "--"); !checked) return report_error(checked.error());
  }
  auto names = read_vehicle_names(source.vehicles);
  if (!names) return report_error(names.error());
  std::optional<vision::Calibration> calibration;
  if (!source.emulated()) {
    auto read = read_calibration_file(source.calibration_file);
    if (!read) return report_error(read.error());
    calibration = std::move(*read);
  }
  Watch watch{arguments, std::move(*names)};
  return watch.run(std::move(calibration));
}

}  // namespace cosiva::app
