#include "cosiva/experiments/positioning/metrology/evo_zip.h"

#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

struct NamedFile {
  const char* name;
  std::string bytes;
};

/// The bytes of a zip with these files, uncompressed and dated 1980-01-01 so that equal content makes equal archives.
std::string zip_of(const std::array<NamedFile, 4>& files) {
  zip_source_t* const buffer = zip_source_buffer_create(nullptr, 0, 0, nullptr);
  zip_t* const archive = zip_open_from_source(buffer, ZIP_TRUNCATE, nullptr);
  COSIVA_EXPECT(archive != nullptr);
  zip_source_keep(buffer);  // zip_close releases the archive's reference, and the bytes are read after it
  for (const NamedFile& file : files) {
    zip_source_t* const content = zip_source_buffer(archive, file.bytes.data(), file.bytes.size(), 0);
    const zip_int64_t added = zip_file_add(archive, file.name, content, 0);
    COSIVA_EXPECT(added >= 0);
    const auto index = static_cast<zip_uint64_t>(added);
    constexpr zip_uint16_t first_of_january_1980 = 0x0021;
    const bool described = zip_set_file_compression(archive, index, ZIP_CM_STORE, 0) == 0 &&
                           zip_file_set_dostime(archive, index, 0, first_of_january_1980, 0) == 0 &&
                           zip_file_set_external_attributes(archive, index, 0, ZIP_OPSYS_DOS, 0) == 0;
    COSIVA_EXPECT(described);
  }
  const bool written = zip_close(archive) == 0 && zip_source_open(buffer) == 0;
  COSIVA_EXPECT(written);
  zip_stat_t metadata{};
  const bool measured = zip_source_stat(buffer, &metadata) == 0;
  COSIVA_EXPECT(measured);
  std::string bytes(metadata.size, '\0');
  const zip_int64_t read = zip_source_read(buffer, bytes.data(), bytes.size());
  COSIVA_EXPECT(read == static_cast<zip_int64_t>(bytes.size()));
  zip_source_close(buffer);
  zip_source_free(buffer);
  return bytes;
}

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xFFU));
}

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
  return zip_of({{{"info.json", info.take()},
                  {"stats.json", stats.take()},
                  {"error_array.npy", npy(errors_m)},
                  {"timestamps.npy", npy(times_s)}}});
}

}  // namespace cosiva::experiments
