// Images by OpenCV (Apache-2.0), as a separate library: opened only for an image that CoSiVA cannot read itself,
// because a command linked with OpenCV would take a tenth of a second longer to start, each time.
#include "cosiva/app/gvs/opencv_images.h"

#include <chrono>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <utility>
#include <vector>

namespace {

using cosiva::app::OpencvStream;
using cosiva::vision::Image;

/// Converts any image to grey: 0.299 R + 0.587 G + 0.114 B, as read_netpbm does.
bool to_grey(const cv::Mat& from, Image& image) {
  if (from.empty() || from.depth() != CV_8U) return false;
  const int channels = from.channels();
  if (channels != 1 && channels != 3 && channels != 4) return false;
  image = Image::filled({static_cast<std::size_t>(from.cols), static_cast<std::size_t>(from.rows)}, 0);
  std::size_t at = 0;
  for (int row = 0; row < from.rows; ++row) {
    const unsigned char* pixel = from.ptr<unsigned char>(row);
    for (int column = 0; column < from.cols; ++column, pixel += channels) {
      const unsigned sum =
          channels == 1 ? 1000U * pixel[0] : 114U * pixel[0] + 587U * pixel[1] + 299U * pixel[2];  // B, G, R
      image.pixels[at++] = static_cast<std::uint8_t>((sum + 500U) / 1000U);
    }
  }
  return true;
}

class FrameStream final : public OpencvStream {
 public:
  explicit FrameStream(const cv::VideoCapture& capture) : capture_{capture} {}
  bool next(Image& image, double& stamp_s) override {
    cv::Mat frame;
    if (!capture_.read(frame) || !to_grey(frame, image)) return false;
    // V4L2: the driver's stamp; a file: its own time. Without either: the time of arrival.
    const double container_s = 1e-3 * capture_.get(cv::CAP_PROP_POS_MSEC);
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    stamp_s = container_s > 0.0 || number_ == 0 ? container_s : std::chrono::duration<double>(now).count();
    ++number_;
    return true;
  }

 private:
  cv::VideoCapture capture_;
  std::size_t number_{0};
};

std::unique_ptr<OpencvStream> stream_of(const cv::VideoCapture& capture) {
  if (!capture.isOpened()) return nullptr;
  return std::make_unique<FrameStream>(capture);
}

class Library final : public cosiva::app::Opencv {
 public:
  bool decode(const std::string& bytes, Image& image) const override {
    try {
      // OpenCV reads only; its type knows no constant bytes.
      // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
      const cv::Mat all(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
      return to_grey(cv::imdecode(all, cv::IMREAD_GRAYSCALE), image);
    } catch (const cv::Exception&) {
      return false;
    }
  }
  std::unique_ptr<OpencvStream> open_video(const std::string& file) const override {
    try {
      return stream_of(cv::VideoCapture{file});
    } catch (const cv::Exception&) {
      return nullptr;
    }
  }
  std::unique_ptr<OpencvStream> open_camera(int number) const override {
    try {
      return stream_of(cv::VideoCapture{number, cv::CAP_V4L2});
    } catch (const cv::Exception&) {
      return nullptr;
    }
  }
};

}  // namespace

extern "C" const cosiva::app::Opencv* cosiva_opencv();
extern "C" const cosiva::app::Opencv* cosiva_opencv() {
  static const Library library;
  return &library;
}
