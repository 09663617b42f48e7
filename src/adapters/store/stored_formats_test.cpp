// Stores that earlier versions have written are read, verified and replayed; a snapshot of another format is replaced
// by the state that the server persisted last. testdata/README.md describes the stored ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/store/live_store.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/journal/store/store_reading.h"
#include "cosiva/journal/store/store_verifier.h"
#include "cosiva/virtual/server/context/server_options.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/testing/vehicle_fixture.h"
#include "cosiva/wire/runtime/snapshot.h"

namespace cosiva::adapters {
namespace {

namespace server_fixture = virtual_side::fixture;
namespace vda = wire::vda5050;
using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;
using virtual_side::ServerCore;
using virtual_side::ServerOptions;
using wire::InputKind;

std::string digest_of(const ServerCore& server) {
  Digest digest;
  server.fold(digest);
  return digest.hex();
}

/// Of the elements of a list in the server's snapshot, the texts of a field.
std::vector<std::string> listed(const ServerCore& server, const char* list, const char* field) {
  std::vector<std::string> texts;
  const auto snapshot = JsonValue::parse(server.snapshot_json());
  for (const JsonValue& one : *snapshot->find(list)->array()) texts.push_back(one.text(field).value_or(""));
  return texts;
}

/// A server with one vehicle on the oval, which writes its store as the live server does, in virtual time.
class StoringServer {
 public:
  /// @param format  of its snapshots, where not the present one
  StoringServer(const std::string& folder, std::optional<std::uint32_t> format) : format_{format} {
    options_.zone = server_fixture::oval();
    server_ = std::make_unique<ServerCore>(options_);
    runner_.emplace(*server_);
    LiveStoreOptions options;
    options.checkpoint_period = 150;
    store_ = std::move(*LiveStore::open(loop_, folder, options));
    store_->set_complete_state([this] { return complete_state(); });
    give(InputKind::configure, "server", to_json(options_));
    give(InputKind::link, "", "up");
    give(InputKind::message, vehicle_.topic("connection"),
         vda::encode(vehicle_.connection(now_, wire::ConnectionState::online)), true);
  }

  void run_for(SimDuration duration) {
    for (const SimTime end = now_ + duration; now_ < end;) {
      now_ += 20ms;
      vehicle_.step(20ms);
      if (std::exchange(vehicle_.state_due, false) || ++steps_ % 50 == 0)
        give(InputKind::message, vehicle_.topic("state"), vda::encode(vehicle_.state(now_)));
      give(InputKind::tick, "", "");
    }
  }
  /// A command that is durable before the server has it; it is killed before where `executed` is false.
  void command(const std::string& json, bool executed = true) {
    bool decided = false;
    store_->propose({now_, InputKind::proposal, "http", json, false}, [&](const Result<void>& kept) {
      EXPECT_TRUE(kept);
      if (executed) give(InputKind::command, "http", json, true);
      decided = true;
    });
    EXPECT_TRUE(loop_.run_until([&] { return decided; }, 5s));
  }
  void stop(const std::string& json) { give(InputKind::command, "http", json); }
  void end() { store_->drain(); }
  [[nodiscard]] std::string digest() const { return digest_of(*server_); }

 private:
  void give(InputKind kind, std::string source, std::string payload, bool flag = false) {
    const wire::Input input{now_, kind, std::move(source), std::move(payload), flag};
    store_->append(input);
    for (const wire::Effect& effect : runner_->feed(input)) {
      if (const auto* state = std::get_if<wire::Persist>(&effect))
        store_->append({now_, InputKind::persisted, {}, state->bytes, false});
      if (const auto* message = std::get_if<wire::Publish>(&effect)) vehicle_.receive(*message);
    }
    store_->complete();
  }
  [[nodiscard]] std::optional<journal::CoreState> complete_state() const {
    std::string bytes = server_->snapshot().value();
    if (format_) {
      const auto snapshot = wire::Snapshot::read(bytes).value();
      wire::Snapshot::Head head = snapshot.head();
      head.format = *format_;
      bytes = wire::Snapshot{head, snapshot.content()}.text();
    }
    return journal::CoreState{std::move(bytes), runner_->history().value(), {}};
  }

  std::optional<std::uint32_t> format_;
  EventLoop loop_;
  ServerOptions options_;
  std::unique_ptr<ServerCore> server_;
  std::optional<wire::CoreRunner> runner_;
  std::unique_ptr<LiveStore> store_;
  SimTime now_{virtual_epoch};
  std::shared_ptr<const zone::TrafficZone> zone_{zone::Rtm::initialise(server_fixture::oval())->shared_zone()};
  server_fixture::FixtureVehicle vehicle_{zone_, wire::VehicleId{"CoSiVA", "AIV1"}, zone::TrackPosition{0, 0.5}};
  int steps_{0};
};

/// Commands before and after the snapshot; the server is killed before it is given the last one. Returns its digest.
std::string write_store(const std::string& folder, std::optional<std::uint32_t> format = std::nullopt) {
  StoringServer server{folder, format};
  server.run_for(1s);
  server.command(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":1.0,"y":0.5}})");
  server.command(R"({"id":"C-1","command":"close","section":"east"})");
  server.run_for(3s);
  server.command(R"({"command":"add","virtualObject":{"id":"O1","kind":"obstacle","x":0.5,"y":0.5}})");
  server.stop(R"({"id":"S-1","command":"stop","vehicle":"*","actionId":"S-1"})");
  server.run_for(1s);
  server.command(R"({"command":"add","virtualObject":{"id":"P2","kind":"person","x":1.5,"y":0.5}})", false);
  server.end();
  return server.digest();
}

/// What an earlier process left in a store, and a server that was started from it as LiveShell starts one.
struct Restarted {
  explicit Restarted(const std::string& folder) {
    EventLoop loop;
    auto store = LiveStore::open(loop, folder, {});
    if (!store) {
      ADD_FAILURE() << to_string(store.error());
      return;
    }
    const InputStore::Left left = (*store)->take_left();
    accepted = left.accepted;
    const ServerOptions options = options_in(folder);
    server = std::make_unique<ServerCore>(options);
    const Result<void> continued =
        left.state ? server->continue_from(left.state->snapshot) : fail("none", "no snapshot");
    wire::Effects effects;
    if (continued) {
      for (const wire::Input& input : left.inputs) server->handle(input, effects);
      return;
    }
    refusal = continued.error().code;
    server->handle({virtual_epoch + 1h, InputKind::configure, "server", to_json(options), false}, effects);
    server->handle({virtual_epoch + 1h, InputKind::restore, "state", left.persisted.value_or(""), false}, effects);
  }
  /// As the first record has them.
  static ServerOptions options_in(const std::string& folder) {
    std::optional<ServerOptions> options;
    const auto disk = PosixDisk::open(folder, PosixDisk::Use::read);
    const auto read = journal::read_store(**disk, [&](journal::RecordNumber number, const journal::RecordView& record) {
      if (number == 1) options = virtual_side::server_options_from_json(std::string(record.payload)).value();
    });
    EXPECT_TRUE(read && !read->damage && !read->torn);
    return options.value_or(ServerOptions{});
  }

  std::unique_ptr<ServerCore> server;
  std::vector<wire::Input> accepted;
  std::string refusal;  ///< of the snapshot; empty: the server continued from it
};

/// What write_store() has made of the platform, whatever of the store was usable.
void expect_what_was_accepted(const Restarted& restarted) {
  ASSERT_NE(restarted.server, nullptr);
  const ServerCore& server = *restarted.server;
  EXPECT_THAT(listed(server, "virtualObjects", "id"), ElementsAre("P1", "O1"));
  const auto snapshot = JsonValue::parse(server.snapshot_json());
  EXPECT_EQ(snapshot->find("zone")->find("closed")->array()->size(), 1U) << "the section east";
  ASSERT_EQ(restarted.accepted.size(), 1U) << "the command that no server was given";
  EXPECT_THAT(restarted.accepted.front().payload, ::testing::HasSubstr("P2"));
  // The Stop holds for a vehicle that comes later.
  wire::Effects effects;
  SimTime now = virtual_epoch + 2h;
  const auto give = [&](InputKind kind, std::string source, std::string payload) {
    effects.clear();
    restarted.server->handle({now, kind, std::move(source), std::move(payload), false}, effects);
  };
  const auto zone = zone::Rtm::initialise(server_fixture::oval())->shared_zone();
  server_fixture::FixtureVehicle vehicle{zone, wire::VehicleId{"CoSiVA", "AIV2"}, zone::TrackPosition{2, 0.5}};
  give(InputKind::link, "", "up");
  give(InputKind::message, vehicle.topic("connection"),
       vda::encode(vehicle.connection(now, wire::ConnectionState::online)));
  bool stopped = false;
  for (int i = 0; i < 100 && !stopped; ++i, now += 20ms) {
    give(InputKind::message, vehicle.topic("state"), vda::encode(vehicle.state(now)));
    give(InputKind::tick, "", "");
    for (const wire::Effect& effect : effects) {
      const auto* message = std::get_if<wire::Publish>(&effect);
      stopped = stopped || (message != nullptr && message->topic == vehicle.topic("instantActions") &&
                            message->payload.find("startPause") != std::string::npos);
    }
  }
  EXPECT_TRUE(stopped);
}

/// A copy that may be written.
std::string copied(const std::filesystem::path& folder, const testing::Scratch& scratch) {
  const std::string copy = scratch / folder.filename().string();
  std::filesystem::copy(folder, copy);
  return copy;
}

std::vector<std::filesystem::path> stored_folders() {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator{source_dir() + "/src/adapters/store/testdata"})
    if (entry.is_directory()) folders.push_back(entry.path());
  std::ranges::sort(folders);
  return folders;
}

/// A server that was given all inputs in the store from the first on.
std::unique_ptr<ServerCore> replayed(const std::string& folder) {
  auto server = std::make_unique<ServerCore>(Restarted::options_in(folder));
  const auto disk = PosixDisk::open(folder, PosixDisk::Use::read);
  wire::Effects effects;
  EXPECT_TRUE(journal::read_store(**disk, [&](journal::RecordNumber, const journal::RecordView& record) {
    if (record.kind < static_cast<std::uint8_t>(InputKind::proposal)) server->handle(record.input(), effects);
  }));
  return server;
}

class StoredFormats : public ::testing::TestWithParam<std::filesystem::path> {};

TEST_P(StoredFormats, are_verified_from_the_first_record_to_the_last) {
  testing::Scratch scratch;
  const auto disk = PosixDisk::open(copied(GetParam(), scratch), PosixDisk::Use::read);
  ASSERT_TRUE(disk);
  std::uint64_t records = 0;
  std::vector<int> kinds(12, 0);
  const auto content =
      journal::read_store(**disk, [&](journal::RecordNumber number, const journal::RecordView& record) {
        EXPECT_EQ(number, ++records);
        ++kinds.at(record.kind);
      });
  ASSERT_TRUE(content);
  EXPECT_FALSE(content->damage) << to_string(*content->damage);
  EXPECT_FALSE(content->torn);
  EXPECT_GT(records, 200U);
  for (const InputKind kind : {InputKind::configure, InputKind::message, InputKind::link, InputKind::command,
                               InputKind::tick, InputKind::proposal, InputKind::persisted, InputKind::snapshot})
    EXPECT_GT(kinds.at(static_cast<std::size_t>(kind)), 0) << static_cast<int>(kind);
}

TEST_P(StoredFormats, replay_to_the_same_state_each_time) {
  testing::Scratch scratch;
  const std::string folder = copied(GetParam(), scratch);
  const auto server = replayed(folder);
  EXPECT_THAT(listed(*server, "aivs", "id"), ElementsAre("CoSiVA/AIV1"));
  EXPECT_THAT(listed(*server, "virtualObjects", "id"), ElementsAre("P1", "O1"));
  EXPECT_THAT(listed(*server, "commands", "id"), Contains("S-1.AIV1"));
  EXPECT_EQ(digest_of(*replayed(folder)), digest_of(*server));
}

TEST_P(StoredFormats, lose_nothing_that_was_accepted_when_a_server_of_this_version_starts) {
  testing::Scratch scratch;
  expect_what_was_accepted(Restarted{copied(GetParam(), scratch)});
}

INSTANTIATE_TEST_SUITE_P(Folders, StoredFormats, ::testing::ValuesIn(stored_folders()), [](const auto& folder) {
  std::string name = folder.param.filename().string();
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
});

TEST(StoredServer, continues_with_the_digest_that_it_had_which_is_that_of_all_inputs_from_the_first_on) {
  testing::Scratch scratch;
  const char* const kept = std::getenv("COSIVA_STORED_FORMAT");  // a folder of testdata to be made
  const std::string folder = kept == nullptr ? scratch / "store" : std::string(kept);
  const std::string digest = write_store(folder);
  testing::Scratch copy;
  const Restarted restarted{copied(folder, copy)};
  EXPECT_EQ(restarted.refusal, "");
  EXPECT_EQ(digest_of(*restarted.server), digest);
  EXPECT_EQ(digest_of(*replayed(folder)), digest);
}

TEST(StoredServer, of_a_snapshot_in_another_format_continues_with_the_state_that_was_persisted_last) {
  for (const std::uint32_t format : {ServerCore::snapshot_format - 1, ServerCore::snapshot_format + 1}) {
    testing::Scratch scratch;
    write_store(scratch / "store", format);
    const Restarted restarted{scratch / "store"};
    EXPECT_EQ(restarted.refusal, "snapshot.format") << format;
    EXPECT_THAT(listed(*restarted.server, "aivs", "id"), Not(Contains("CoSiVA/AIV1"))) << "a part of the snapshot";
    expect_what_was_accepted(restarted);
  }
}

}  // namespace
}  // namespace cosiva::adapters
