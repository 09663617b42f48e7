#include "cosiva/experiments/positioning/recording/recording.h"
#include "cosiva/experiments/positioning/recording/replayed.h"

#include "target.h"

/// The input is a folder: "== name" lines begin its files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::experiments;
  auto text = cosiva::fuzz::as_text(data, size);
  RecordingFiles files;
  std::string name = "odometry.csv";
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const auto line = text.substr(0, end);
    if (line.starts_with("== ") && line.size() > 3)  // every file has a name
      name = line.substr(3);
    else
      files[name].append(line).append("\n");
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  }
  const auto recording = read_recording("fuzz", files);
  if (!recording) {
    COSIVA_EXPECT(recording.error().code.starts_with("recording.") && !recording.error().message.empty());
    COSIVA_EXPECT(!recording.error().location.empty());
    return 0;
  }
  const auto trial = replayed(*recording);
  if (!trial) {
    COSIVA_EXPECT(trial.error().code.starts_with("recording.") && !trial.error().message.empty());
    return 0;
  }
  COSIVA_EXPECT(!trial->moments.empty());
  for (const Moment& moment : trial->moments) COSIVA_EXPECT(moment.events <= trial->events.size());
  return 0;
}
