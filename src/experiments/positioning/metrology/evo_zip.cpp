#include "cosiva/experiments/positioning/metrology/evo_zip.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

/// CRC-32 as zip has it (reflected 0xEDB88320).
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xFFU));
}

/// A zip of uncompressed files, dated 1980-01-01 so that equal content makes equal files.
class Zip {
 public:
  void add(std::string_view name, std::string_view bytes) {
    const std::size_t offset = out_.size();
    const std::uint32_t crc = crc32(bytes);
    put(out_, 0x04034B50, 4);
    header(out_, name, bytes, crc);
    out_ += name;
    out_ += bytes;
    put(directory_, 0x02014B50, 4);
    put(directory_, 20, 2);  // made by
    header(directory_, name, bytes, crc);
    put(directory_, 0, 2);  // comment
    put(directory_, 0, 2);  // disk
    put(directory_, 0, 2);  // internal attributes
    put(directory_, 0, 4);  // external attributes
    put(directory_, offset, 4);
    directory_ += name;
    ++count_;
  }
  [[nodiscard]] std::string finished() const {
    std::string all = out_ + directory_;
    put(all, 0x06054B50, 4);
    put(all, 0, 4);  // disks
    put(all, count_, 2);
    put(all, count_, 2);
    put(all, directory_.size(), 4);
    put(all, out_.size(), 4);
    put(all, 0, 2);  // comment
    return all;
  }

 private:
  static void header(std::string& out, std::string_view name, std::string_view bytes, std::uint32_t crc) {
    put(out, 20, 2);      // version needed
    put(out, 0, 2);       // flags
    put(out, 0, 2);       // stored
    put(out, 0, 2);       // time
    put(out, 0x0021, 2);  // date
    put(out, crc, 4);
    put(out, bytes.size(), 4);
    put(out, bytes.size(), 4);
    put(out, name.size(), 2);
    put(out, 0, 2);  // extra
  }
  std::string out_;
  std::string directory_;
  std::size_t count_{0};
};

/// A vector as NumPy's format 1.0 stores it: little-endian doubles.
std::string npy(const std::vector<double>& values) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(values.size()) + ",), }";
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  std::string out = "\x93NUMPY";
  put(out, 1, 1);
  put(out, 0, 1);
  put(out, header.size(), 2);
  out += header;
  for (const double v : values) put(out, std::bit_cast<std::uint64_t>(v), 8);
  return out;
}

double root_of_variance(const std::vector<double>& values) { return std::sqrt(statistics::variance(values)); }

/// As NumPy's median: the mean of the two central values for an even number.
double centre_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

}  // namespace

std::string evo_zip(std::string_view title, const std::vector<double>& times_s, const std::vector<double>& errors_m,
                    Alignment alignment) {
  double sse = 0.0;
  double largest = 0.0;
  double smallest = errors_m.empty() ? 0.0 : errors_m.front();
  for (const double e : errors_m) {
    sse += e * e;
    largest = e > largest ? e : largest;
    smallest = e < smallest ? e : smallest;
  }
  JsonWriter info;
  info.begin_object()
      .field("title", "APE w.r.t. translation part (m)\n(" + std::string(text_of(alignment)) + ")")
      .field("label", "APE (m)");
  info.field("ref_name", "ground_truth").field("est_name", title).end_object();
  JsonWriter stats;
  stats.begin_object().field("rmse", statistics::root_mean_square(errors_m));
  stats.field("mean", statistics::mean(errors_m)).field("std", root_of_variance(errors_m));
  stats.field("median", centre_of(errors_m)).field("min", smallest).field("max", largest).field("sse", sse);
  stats.end_object();
  Zip zip;
  zip.add("info.json", info.text());
  zip.add("stats.json", stats.text());
  zip.add("error_array.npy", npy(errors_m));
  zip.add("timestamps.npy", npy(times_s));
  return zip.finished();
}

}  // namespace cosiva::experiments
