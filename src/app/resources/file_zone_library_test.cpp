#include "cosiva/app/resources/file_zone_library.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::HasSubstr;

/// The user's data folder lies in this scratch folder.
class FileZoneLibraryTest : public ::testing::Test {
 protected:
  FileZoneLibraryTest() { ::setenv("XDG_DATA_HOME", (scratch_ / "data").c_str(), 1); }
  ~FileZoneLibraryTest() override { ::unsetenv("XDG_DATA_HOME"); }
  FileZoneLibraryTest(const FileZoneLibraryTest&) = delete;
  FileZoneLibraryTest& operator=(const FileZoneLibraryTest&) = delete;
  Scratch scratch_;
  FileZoneLibrary library_;
};

TEST_F(FileZoneLibraryTest, lists_ready_zones_by_name_with_their_titles_and_loads_each) {
  scratch_.write("data/cosiva/zones/mine.toml", "# My site: with a pit\nname = \"mine\"\n");
  const auto zones = library_.zones();
  EXPECT_TRUE(std::ranges::is_sorted(zones, {}, &ZoneLibrary::Entry::name));
  const auto mine = std::ranges::find(zones, "mine", &ZoneLibrary::Entry::name);
  ASSERT_NE(mine, zones.end());
  EXPECT_EQ(mine->title, "My site");
  for (const ZoneLibrary::Entry& entry : zones) EXPECT_TRUE(library_.load(entry.name)) << entry.name;
  EXPECT_EQ(library_.load("lacet5").error().code, "zone.missing");
}

TEST_F(FileZoneLibraryTest, saves_edits_in_the_users_own_folder_where_the_name_finds_them) {
  const auto folder = library_.edits_folder();
  ASSERT_TRUE(folder);
  EXPECT_EQ(*folder, scratch_ / "data/cosiva/zones");
  EXPECT_TRUE(std::filesystem::is_directory(*folder));
  const auto lacet4 = library_.load("lacet4");
  ASSERT_TRUE(lacet4);
  const std::string file = *folder + "/copy" + library_.file_ending(lacet4->format);
  ASSERT_TRUE(library_.write(file, *lacet4));
  EXPECT_EQ(library_.read(file)->text, lacet4->text);
  EXPECT_EQ(library_.load("copy")->origin, file);
}

TEST_F(FileZoneLibraryTest, writes_sidecars_under_their_own_ending) {
  const zone::ZoneConfiguration with_sidecar{"lif", "depot", "{}", "name = 'depot'\n"};
  const std::string file = *library_.edits_folder() + "/depot" + library_.file_ending("lif");
  ASSERT_TRUE(library_.write(file, with_sidecar));
  EXPECT_EQ(adapters::read_file(*library_.edits_folder() + "/depot" + std::string(library_.sidecar_ending())).value(),
            "name = 'depot'\n");
}

TEST_F(FileZoneLibraryTest, names_the_folder_that_could_not_be_created) {
  scratch_.write("file", "a file");
  ::setenv("XDG_DATA_HOME", (scratch_ / "file").c_str(), 1);
  const auto folder = library_.edits_folder();
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, "zone.folder");
  EXPECT_THAT(folder.error().message, HasSubstr(scratch_ / "file"));
}

}  // namespace
}  // namespace cosiva::app
