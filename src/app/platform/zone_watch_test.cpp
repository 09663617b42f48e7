#include "cosiva/app/platform/zone_watch.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_value.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string straight(const std::string& length) {
  return "name = \"way\"\nformat_version = 1\n[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = " + length +
         "\nnext = []\n";
}

/// A core that accepts any readable zone, and a file that is edited.
class Watched : public ::testing::Test {
 protected:
  Watched() { in_force = load_zone(file).value(); }

  void save(const std::string& text) const { scratch.write("way.toml", text); }
  void check(int times = 1) {
    for (int i = 0; i < times; ++i) watch.check();
  }

  Scratch scratch;
  std::string file{scratch.write("way.toml", straight("2.0"))};
  std::optional<zone::ZoneConfiguration> in_force;
  std::vector<std::string> given;
  std::vector<std::string> lines;
  adapters::EventLoop loop;
  ZoneWatch watch{loop,
                  file,
                  {},
                  {[this] { return in_force; },
                   [this](const std::string& command) {
                     given.push_back(command);
                     auto zone = zone::zone_configuration_from_json(*JsonValue::parse(command)->find("zone"));
                     if (zone::Rtm::initialise(*zone)) in_force = std::move(*zone);
                   },
                   [this](const std::string& text) { lines.push_back(text); }}};
};

TEST_F(Watched, an_unchanged_file_is_not_reported) {
  check(5);
  save(straight("2.0"));  // saved again without a change
  check(5);
  EXPECT_THAT(given, IsEmpty());
  EXPECT_THAT(lines, IsEmpty());
}

TEST_F(Watched, a_change_is_applied_once_the_file_no_longer_changes) {
  save(straight("3.0"));
  check();
  EXPECT_THAT(given, IsEmpty()) << "a program may still be writing";
  save(straight("4.0"));
  check();
  EXPECT_THAT(given, IsEmpty());
  check();
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(in_force->text, straight("4.0"));
  EXPECT_EQ(JsonValue::parse(given[0])->text("command"), "switch");
  check(5);
  EXPECT_EQ(given.size(), 1U);
  EXPECT_THAT(lines, ElementsAre(HasSubstr("switched to it")));
}

TEST_F(Watched, content_that_the_page_saved_is_in_force_already) {
  in_force->text = straight("5.0");
  save(straight("5.0"));
  check(3);
  EXPECT_THAT(given, IsEmpty());
  save(straight("2.0"));  // and edited back to its original content
  check(3);
  EXPECT_EQ(given.size(), 1U);
}

TEST_F(Watched, a_broken_file_is_passed_on_for_its_refusal_and_reported_once) {
  save("name = 3\n");
  check(5);
  EXPECT_EQ(given.size(), 1U) << "the platform reports the reason on its page";
  EXPECT_EQ(in_force->text, straight("2.0"));
  EXPECT_THAT(lines, ElementsAre(::testing::AllOf(HasSubstr("stays"), HasSubstr("way.toml:1"))));
  save(straight("3.0"));
  check(2);
  EXPECT_EQ(in_force->text, straight("3.0"));
}

TEST_F(Watched, a_briefly_missing_file_is_not_reported_but_a_missing_file_is) {
  std::filesystem::remove(file);
  check();
  save(straight("2.0"));
  check(3);
  EXPECT_THAT(lines, IsEmpty());
  std::filesystem::remove(file);
  check(5);
  EXPECT_THAT(lines, ElementsAre(HasSubstr("cannot be read")));
  EXPECT_THAT(given, IsEmpty());
  save(straight("6.0"));
  check(2);
  EXPECT_EQ(in_force->text, straight("6.0"));
}

}  // namespace
}  // namespace cosiva::app
