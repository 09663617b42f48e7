#include "cosiva/app/resources/zone_files.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::HasSubstr;

/// The user's own folder of zones is this scratch's.
class OwnFolder {
 public:
  OwnFolder() { ::setenv("XDG_DATA_HOME", scratch.path().c_str(), 1); }
  ~OwnFolder() { ::unsetenv("XDG_DATA_HOME"); }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  std::string write(const std::string& name, const std::string& text) const {
    return scratch.write("cosiva/zones/" + name, text);
  }
  Scratch scratch;
};

const ReadyZone* named(const std::vector<ReadyZone>& zones, const std::string& name) {
  const auto found = std::ranges::find(zones, name, &ReadyZone::name);
  return found == zones.end() ? nullptr : &*found;
}

TEST(ZoneFiles, of_every_format_are_found_by_name) {
  const OwnFolder own;
  const std::string layout = own.write("area.lif.json", "{}");
  const std::string road = own.write("road.xodr", "<OpenDRIVE/>");
  own.write("area.zone.toml", "name = 'area'\n");
  own.write("package.json", "{}");
  EXPECT_EQ(find_zone_file("area").value(), layout);
  EXPECT_EQ(find_zone_file("road").value(), road);
  const auto ready = ready_zones();
  EXPECT_NE(named(ready, "area"), nullptr);
  EXPECT_NE(named(ready, "road"), nullptr);
  EXPECT_NE(named(ready, "lacet4"), nullptr) << "those of the source tree";
  EXPECT_EQ(named(ready, "area.zone"), nullptr) << "a sidecar file is no zone";
  EXPECT_EQ(named(ready, "package"), nullptr) << "not every such file is a zone";
  EXPECT_THAT(find_zone_file("aera").error().message, HasSubstr("did you mean 'area'?"));
}

TEST(ZoneFiles, include_their_sidecar_file) {
  Scratch scratch;
  const std::string file = scratch.write("area.lif.json", "{}");
  EXPECT_EQ(load_zone(file)->sidecar, "");
  scratch.write("area.zone.toml", "# beside\n");
  const auto zone = load_zone(file);
  ASSERT_TRUE(zone);
  EXPECT_EQ(zone->format, "lif");
  EXPECT_EQ(zone->sidecar, "# beside\n");
  EXPECT_EQ(load_zone(file, scratch.write("other.toml", "# other\n"))->sidecar, "# other\n");
  EXPECT_FALSE(load_zone(file, scratch / "missing.toml")) << "a given sidecar file must exist";
}

TEST(ZoneFiles, that_are_complete_have_no_sidecar) {
  Scratch scratch;
  const std::string file = scratch.write("mine.toml", "name = 'mine'\n");
  scratch.write("mine.zone.toml", "# whatever\n");
  EXPECT_EQ(load_zone(file)->sidecar, "");
}

TEST(ZoneFiles, of_other_kinds_are_refused_with_advice) {
  Scratch scratch;
  const auto text = load_zone(scratch.write("zone.txt", ""));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, "zone.format");
  EXPECT_THAT(text.error().message, HasSubstr(".toml"));
  const auto sidecar = load_zone(scratch.write("area.zone.toml", ""));
  ASSERT_FALSE(sidecar);
  EXPECT_THAT(sidecar.error().message, HasSubstr("name that file"));
}

TEST(ZoneFiles, are_titled_by_the_first_comment_of_sidecar_or_file) {
  const OwnFolder own;
  own.write("a.toml", "# A small yard (for lorries)\nname = 'a'\n");
  own.write("b.toml", "name = 'b'\n");
  own.write("c.lif.json", "{}");
  own.write("c.zone.toml", "#   The control area: three lanes\n");
  const auto ready = ready_zones();
  EXPECT_EQ(title_of(*named(ready, "a")), "A small yard");
  EXPECT_EQ(title_of(*named(ready, "b")), "b");
  EXPECT_EQ(title_of(*named(ready, "c")), "The control area");
}

TEST(ZoneFiles, are_written_with_their_sidecar) {
  Scratch scratch;
  ASSERT_TRUE(write_zone(scratch / "area.lif.json", {"lif", "", "{}", "# beside\n"}));
  EXPECT_EQ(adapters::read_file(scratch / "area.zone.toml").value(), "# beside\n");
  EXPECT_EQ(adapters::read_file(scratch / "area.lif.json").value(), "{}");
  EXPECT_FALSE(write_zone(scratch / "missing/area.lif.json", {"lif", "", "{}", {}}));
}

}  // namespace
}  // namespace cosiva::app
