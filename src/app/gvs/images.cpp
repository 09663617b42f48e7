#include "cosiva/app/gvs/images.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/gvs/opencv_images.h"
#include "cosiva/base/text.h"

namespace cosiva::app {
namespace {

namespace fs = std::filesystem;

/// Opened at the first use, from the command's folder (of a test: from its build's command); stays open.
Result<const Opencv*> opencv(const std::string& needed_for) {
  static const Opencv* loaded = nullptr;
  if (loaded != nullptr) return loaded;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error).parent_path();
  std::string why = "no reason given";
  for (const fs::path& folder : {self, self / "..", self / ".." / "..", self / ".." / ".." / ".."}) {
    const std::string library = (folder / "cosiva_opencv.so").string();
    if (!fs::exists(library, error)) continue;
    void* const opened = dlopen(library.c_str(), RTLD_NOW);
    if (opened == nullptr) {
      const char* const reason = dlerror();
      if (reason != nullptr) why = reason;
      continue;
    }
    using Get = const Opencv* (*)();
    if (const auto get = reinterpret_cast<Get>(dlsym(opened, "cosiva_opencv"))) return loaded = get();
    why = "the library is of another version";
  }
  return fail(
      "opencv.missing",
      needed_for + " is read by OpenCV, which is not available: " + why +
          "; are libopencv-core-dev, libopencv-imgcodecs-dev and libopencv-videoio-dev installed and cosiva built "
          "since? PGM and PPM images do not need OpenCV",
      (self / "cosiva_opencv.so").string());
}

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_netpbm(const std::string& ending) { return ending == ".pgm" || ending == ".ppm"; }
bool is_image(const std::string& ending) {
  constexpr std::array others{".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"};
  return is_netpbm(ending) || std::ranges::find(others, ending) != others.end();
}

Result<std::map<std::string, double>> read_stamps(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  std::map<std::string, double> stamps;
  Lines lines{*text};
  std::string_view line;
  while (lines.next(line)) {
    if (lines.number() == 1 || trimmed(line).empty()) continue;
    const std::string location = file + ":" + std::to_string(lines.number());
    const auto fields = cut_at_commas(line);
    const auto stamp = fields.size() == 2 ? number_of<double>(fields[1]) : std::nullopt;
    if (!stamp) return fail("gvs.images", "expected 'file,stamp_s', found '" + std::string(line) + "'", location);
    if (!stamps.emplace(std::string(fields[0]), *stamp).second)
      return fail("gvs.images", "has '" + std::string(fields[0]) + "' twice", location);
  }
  return stamps;
}

class FolderImages final : public ImageSource {
 public:
  struct One {
    std::string file;
    double stamp_s;
  };
  explicit FolderImages(std::vector<One> all) : all_{std::move(all)} {}
  Result<std::optional<Frame>> next() override {
    if (at_ == all_.size()) return std::optional<Frame>{};
    const One& one = all_[at_++];
    auto image = read_image(one.file);
    if (!image) return tl::unexpected(image.error());
    return std::optional<Frame>{Frame{std::move(*image), one.stamp_s, fs::path(one.file).filename().string()}};
  }

 private:
  std::vector<One> all_;
  std::size_t at_{0};
};

class StreamImages final : public ImageSource {
 public:
  explicit StreamImages(std::unique_ptr<OpencvStream> stream) : stream_{std::move(stream)} {}
  Result<std::optional<Frame>> next() override {
    Frame frame;
    if (!stream_->next(frame.image, frame.stamp_s)) return std::optional<Frame>{};
    frame.name = std::to_string(number_++);
    // A stamp that does not rise (a driver without stamps) would be no time at all.
    if (number_ > 1 && !(frame.stamp_s > before_s_)) frame.stamp_s = before_s_ + 1e-3;
    before_s_ = frame.stamp_s;
    return std::optional<Frame>{std::move(frame)};
  }

 private:
  std::unique_ptr<OpencvStream> stream_;
  std::size_t number_{0};
  double before_s_{0.0};
};

}  // namespace

Result<vision::Image> read_image(const std::string& file) {
  auto bytes = adapters::read_file(file);
  if (!bytes) return tl::unexpected(bytes.error());
  if (is_netpbm(ending_of(file))) return vision::read_netpbm(*bytes, file);
  const auto library = opencv("'" + file + "'");
  if (!library) return tl::unexpected(library.error());
  vision::Image image;
  if (bytes->empty() || !(*library)->decode(*bytes, image))
    return fail("gvs.image", "is no image that OpenCV can read, or is truncated", file);
  return image;
}

Result<std::unique_ptr<ImageSource>> folder_images(const std::string& folder, double rate_hz) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_image(ending_of(entry.path()))) files.push_back(entry.path().string());
  if (error) return fail("gvs.images", "cannot be read: " + error.message(), folder);
  if (files.empty()) return fail("gvs.images", "contains no images (pgm, ppm, png, jpg, bmp, tif, webp)", folder);
  std::ranges::sort(files);
  const std::string stamps_file = (fs::path(folder) / "stamps.csv").string();
  std::vector<FolderImages::One> all;
  if (fs::exists(stamps_file, error)) {
    const auto stamps = read_stamps(stamps_file);
    if (!stamps) return tl::unexpected(stamps.error());
    for (const std::string& file : files) {
      const auto found = stamps->find(fs::path(file).filename().string());
      if (found == stamps->end()) return fail("gvs.images", "has no stamp for '" + file + "'", stamps_file);
      if (!all.empty() && !(found->second > all.back().stamp_s))
        return fail("gvs.images", "the stamp of '" + file + "' is not later than that of the previous image",
                    stamps_file);
      all.push_back({file, found->second});
    }
  } else {
    for (const std::string& file : files) all.push_back({file, static_cast<double>(all.size()) / rate_hz});
  }
  return std::make_unique<FolderImages>(std::move(all));
}

Result<std::unique_ptr<ImageSource>> video_images(const std::string& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return fail("gvs.images", "there is no such file", file);
  const auto library = opencv("a video");
  if (!library) return tl::unexpected(library.error());
  auto stream = (*library)->open_video(file);
  if (!stream) return fail("gvs.images", "is no video that OpenCV can read", file);
  return std::make_unique<StreamImages>(std::move(stream));
}

Result<std::unique_ptr<ImageSource>> camera_images(std::uint32_t number) {
  const auto library = opencv("a camera");
  if (!library) return tl::unexpected(library.error());
  auto stream = (*library)->open_camera(static_cast<int>(number));
  if (!stream) return fail("gvs.images", "no camera responds there", "/dev/video" + std::to_string(number));
  return std::make_unique<StreamImages>(std::move(stream));
}

}  // namespace cosiva::app
