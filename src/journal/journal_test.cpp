#include "cosiva/journal/reader.h"
#include "cosiva/journal/replay.h"
#include "cosiva/journal/writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/journal/crc32c.h"

namespace cosiva::journal {
namespace {

using namespace std::chrono_literals;
using wire::Input;
using wire::InputKind;

TEST(Crc32c, gives_the_published_check_values) {
  EXPECT_EQ(crc32c("123456789"), 0xE3069283U);
  EXPECT_EQ(crc32c(""), 0U);
  // RFC 3720 B.4: 32 bytes of zeros, of ones, and counting up.
  EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8A9136AAU);
  EXPECT_EQ(crc32c(std::string(32, '\xFF')), 0x62A8AB43U);
  std::string counting;
  for (char c = 0; c < 32; ++c) counting += c;
  EXPECT_EQ(crc32c(counting), 0x46DD794EU);
}

TEST(Crc32c, can_be_computed_piece_by_piece) {
  const std::string text = "a journal is read from front to back";
  for (std::size_t cut = 0; cut <= text.size(); ++cut)
    EXPECT_EQ(crc32c(text.substr(cut), crc32c(text.substr(0, cut))), crc32c(text));
}

std::string written(const std::vector<Input>& inputs, const std::optional<std::string>& digest = std::nullopt) {
  std::string bytes;
  Writer writer{[&](std::string_view piece) { bytes += piece; }};
  for (const Input& input : inputs) writer.append(input);
  if (digest) writer.end(SimTime{9s}, *digest);
  return bytes;
}

struct ReadBack {
  std::vector<Input> inputs;
  std::optional<std::string> digest;
  bool truncated{};
  std::optional<Error> error;
};
ReadBack read_all(std::string_view bytes) {
  ReadBack back;
  auto reader = Reader::open(bytes);
  if (!reader) return {{}, {}, false, reader.error()};
  for (;;) {
    auto next = reader->next();
    if (!next) back.error = next.error();
    if (!next || !*next) break;
    back.inputs.push_back(std::move(**next));
  }
  back.digest = reader->recorded_digest();
  back.truncated = reader->truncated();
  return back;
}

const std::vector<Input> three{{SimTime{0s}, InputKind::configure, "server", R"({"zone":"lacet4"})", false},
                               {SimTime{1ns}, InputKind::message, "uagv/v2/m/1/state", std::string("\0\xFF", 2), true},
                               {SimTime{-1ns}, InputKind::tick, "", "", false}};

TEST(Crc32c, is_the_same_with_and_without_the_processor_s_instruction) {
  std::string bytes(2'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i * 31 + 7);
  for (std::size_t from = 0; from < 9; ++from) {
    for (std::size_t length = 0; length < 40; ++length) {
      const std::string_view part = std::string_view{bytes}.substr(from, length);
      EXPECT_EQ(crc32c(part, 0x12345678U), crc32c_by_tables(part, 0x12345678U)) << from << " " << length;
    }
  }
  // The instruction is used on three blocks of 256 bytes at a time.
  for (const std::size_t length : {767U, 768U, 769U, 776U, 1'535U, 1'536U, 2'000U}) {
    const std::string_view part = std::string_view{bytes}.substr(0, length);
    EXPECT_EQ(crc32c(part, 0x12345678U), crc32c_by_tables(part, 0x12345678U)) << length;
  }
}

TEST(Journal, reads_back_what_it_wrote) {
  const ReadBack back = read_all(written(three, "0123456789abcdef"));
  EXPECT_FALSE(back.error);
  EXPECT_EQ(back.inputs, three);
  EXPECT_EQ(back.digest, "0123456789abcdef");
  EXPECT_FALSE(back.truncated);
}

Input any_input(Random& random) {
  const auto text = [&](std::uint64_t most) {
    std::string bytes(random.below(most + 1), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.below(256));
    return bytes;
  };
  return {SimTime{SimDuration{static_cast<std::int64_t>(random.next())}}, static_cast<InputKind>(1 + random.below(8)),
          text(100), text(1000), random.chance(0.5)};
}

TEST(Journal, reads_back_any_input) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "inputs"};
    std::vector<Input> inputs;
    for (auto left = random.below(20); left > 0; --left) inputs.push_back(any_input(random));
    const ReadBack back = read_all(written(inputs));
    RC_ASSERT(!back.error);
    RC_ASSERT(!back.truncated);
    RC_ASSERT(back.inputs == inputs);
    RC_ASSERT(!back.digest);
  }));
}

/// The bytes of the first `hex` block in a document; '#' starts a comment.
std::string hex_block(const std::string& file) {
  std::ifstream document{file};
  std::string bytes;
  std::string line;
  bool inside = false;
  while (std::getline(document, line)) {
    if (line.starts_with("```")) {
      if (inside) break;
      inside = line == "```hex";
      continue;
    }
    if (!inside) continue;
    std::istringstream pairs{line.substr(0, line.find('#'))};
    for (std::string pair; pairs >> pair;) bytes += static_cast<char>(std::stoi(pair, nullptr, 16));
  }
  return bytes;
}

TEST(Journal, is_written_byte_by_byte_as_documented) {
  const std::vector<Input> run{
      {virtual_epoch, InputKind::configure, "server", R"({"zone":"lacet4"})", false},
      {virtual_epoch + 50ms, InputKind::message, "a/b", "hi", true},
      {virtual_epoch + 100ms, InputKind::tick, "", "", false},
  };
  std::string bytes;
  Writer writer{[&](std::string_view piece) { bytes += piece; }};
  for (const Input& input : run) writer.append(input);
  writer.end(virtual_epoch + 100ms, "0123456789abcdef");
  const std::string documented = hex_block(source_dir() + "/docs/protocols/journal.md");
  EXPECT_EQ(bytes, documented);
  EXPECT_EQ(read_all(documented).inputs, run);
}

TEST(Journal, cut_anywhere_gives_the_whole_records_before_the_cut) {
  const std::string whole = written(three, "0123456789abcdef");
  std::vector<std::size_t> ends;
  for (std::size_t n = 0; n <= three.size(); ++n)
    ends.push_back(written({three.begin(), three.begin() + static_cast<std::ptrdiff_t>(n)}).size());
  for (std::size_t cut = ends[0]; cut < whole.size(); ++cut) {
    const ReadBack back = read_all(std::string_view{whole}.substr(0, cut));
    EXPECT_FALSE(back.error) << cut;
    EXPECT_FALSE(back.digest) << cut;
    const auto complete = static_cast<std::size_t>(std::ranges::upper_bound(ends, cut) - ends.begin()) - 1;
    EXPECT_EQ(back.inputs.size(), complete) << cut;
    EXPECT_EQ(back.truncated, std::ranges::find(ends, cut) == ends.end()) << cut;
  }
}

TEST(Journal, detects_any_single_flipped_bit) {
  const std::string whole = written(three, "0123456789abcdef");
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    std::string damaged = whole;
    damaged[bit / 8] = static_cast<char>(static_cast<unsigned char>(damaged[bit / 8]) ^ (1U << (bit % 8)));
    const ReadBack back = read_all(damaged);
    // A longer length may point past the end, like a truncated record; everything else is an error.
    EXPECT_TRUE(back.error || back.truncated) << bit;
    EXPECT_LE(back.inputs.size(), three.size());
  }
}

TEST(Journal, reports_the_offset_of_a_damaged_record_repeatedly) {
  std::string bytes = written(three);
  const std::size_t second = written({three[0]}).size();
  bytes[second + 20] = static_cast<char>(bytes[second + 20] + 1);
  auto reader = Reader::open(bytes);
  ASSERT_TRUE(reader);
  ASSERT_TRUE(reader->next());
  for (int i = 0; i < 3; ++i) {
    const auto next = reader->next();
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, "journal.crc");
    EXPECT_EQ(next.error().location, "offset " + std::to_string(second));
  }
}

/// One record with a correct checksum around any body.
std::string sealed(const std::string& body) {
  std::string record;
  for (unsigned i = 0; i < 4; ++i) record += static_cast<char>((body.size() >> (8U * i)) & 0xFFU);
  record += body;
  const std::uint32_t crc = crc32c(record);
  for (unsigned i = 0; i < 4; ++i) record += static_cast<char>((crc >> (8U * i)) & 0xFFU);
  return "COSIVAJ1" + record;
}
std::string body(char kind, char flag, char source_low, const std::string& rest) {
  return std::string{kind, flag} + std::string(8, '\0') + std::string{source_low, '\0'} + rest;
}

TEST(Journal, rejects_invalid_records_with_a_correct_checksum) {
  EXPECT_FALSE(read_all(sealed(body(7, 0, 0, ""))).error);
  EXPECT_EQ(read_all(sealed(body(0, 0, 0, ""))).error->code, "journal.kind");
  EXPECT_EQ(read_all(sealed(body(12, 0, 0, ""))).error->code, "journal.kind");
  EXPECT_EQ(read_all(sealed(body(7, 2, 0, ""))).error->code, "journal.flag");
  EXPECT_EQ(read_all(sealed(body(7, 0, 5, "abcd"))).error->code, "journal.length");
  EXPECT_EQ(read_all(sealed("short")).error->code, "journal.length");
  EXPECT_EQ(read_all("COSIVAJ1\xFF\xFF\xFF\xFF").error->code, "journal.length");
}

TEST(Journal, takes_a_record_of_12_to_268_566_528_bytes) {
  const auto after_length = [](std::uint32_t length) {
    std::string bytes = "COSIVAJ1";
    for (unsigned i = 0; i < 4; ++i) bytes += static_cast<char>((length >> (8U * i)) & 0xFFU);
    return read_all(bytes);  // the record itself is missing
  };
  EXPECT_EQ(after_length(11).error->code, "journal.length");
  EXPECT_TRUE(after_length(12).truncated);
  EXPECT_TRUE(after_length(268'566'528).truncated);
  EXPECT_EQ(after_length(268'566'529).error->code, "journal.length");
}

TEST(Journal, takes_a_source_that_fills_its_record) {
  const ReadBack back = read_all(sealed(body(2, 1, 4, "abcd")));
  ASSERT_EQ(back.inputs.size(), 1U);
  EXPECT_EQ(back.inputs[0], (Input{SimTime{}, InputKind::message, "abcd", "", true}));
}

TEST(Journal, explains_what_is_wrong) {
  EXPECT_EQ(read_all(sealed(body(7, 2, 0, ""))).error->message, "a flag is 0 or 1, found 2");
  EXPECT_EQ(read_all(sealed(body(12, 0, 0, ""))).error->message, "unknown record kind 12");
  EXPECT_EQ(read_all(sealed("short")).error->message, "a record cannot be 5 bytes long");
  EXPECT_EQ(read_all(written(three, "x") + "more").error->message, "4 bytes follow the end record");
  EXPECT_EQ(read_all(written(three, "x") + "more").error->location,
            "offset " + std::to_string(written(three, "x").size()));
}

TEST(Journal, stores_a_source_of_at_most_65535_bytes) {
  const Input longest{SimTime{1s}, InputKind::message, std::string(65'535, 's'), "payload", false};
  EXPECT_EQ(read_all(written({longest})).inputs, std::vector<Input>{longest});
  const Input longer{SimTime{1s}, InputKind::message, std::string(65'536, 's'), "payload", false};
  EXPECT_DEATH(static_cast<void>(written({longer})), "source.size");
}

TEST(Journal, needs_a_sink) { EXPECT_DEATH(Writer{Writer::Sink{}}, "sink_"); }

TEST(Journal, accepts_only_a_journal) {
  for (const char* bytes : {"", "COSIVA", "COSIVAJ2", "cosivaj1"})
    EXPECT_EQ(read_all(bytes).error->code, "journal.magic") << bytes;
}

TEST(Journal, ends_at_its_end_record) {
  const std::string bytes = written(three, "x") + "more";
  EXPECT_EQ(read_all(bytes).error->code, "journal.after_end");
}

/// Sums up its inputs; publishes the sum on every tick.
class SumCore final : public wire::Core {
 public:
  void handle(const Input& input, wire::Effects& effects) override {
    for (const char c : input.payload) sum += static_cast<unsigned char>(c);
    if (input.kind == InputKind::tick) effects.push_back(wire::Publish{"sum", std::to_string(sum), 0, false});
  }
  [[nodiscard]] SimDuration tick_period() const override { return 100ms; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest& digest) const override { digest.add(sum); }
  std::uint64_t sum{0};
};

Result<std::unique_ptr<wire::Core>> make_sum(const Input&) { return std::make_unique<SumCore>(); }

std::string recorded_run(const std::vector<Input>& inputs) {
  std::string bytes;
  Writer writer{[&](std::string_view piece) { bytes += piece; }};
  SumCore core;
  wire::CoreRunner runner{core, [&](const Input& input) { writer.append(input); }};
  for (const Input& input : inputs) runner.feed(input);
  writer.end(inputs.back().at, runner.digest().hex());
  return bytes;
}

TEST(Replay, gives_the_digest_that_the_live_run_recorded) {
  std::uint64_t sum_at_end = 0;
  const auto replayed =
      replay(recorded_run(three), make_sum, [&](wire::Core& core) { sum_at_end = dynamic_cast<SumCore&>(core).sum; });
  ASSERT_TRUE(replayed) << to_string(replayed.error());
  EXPECT_EQ(replayed->recorded_digest, replayed->digest);
  EXPECT_EQ(replayed->inputs, 3U);
  EXPECT_FALSE(replayed->truncated);
  EXPECT_GT(sum_at_end, 0U);
}

TEST(Replay, of_a_core_that_behaves_differently_gives_another_digest) {
  class Other final : public wire::Core {
   public:
    void handle(const Input&, wire::Effects&) override {}
    [[nodiscard]] SimDuration tick_period() const override { return 1s; }
    [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
    void fold(Digest&) const override {}
  };
  const auto replayed = replay(recorded_run(three), [](const Input&) -> Result<std::unique_ptr<wire::Core>> {
    return std::make_unique<Other>();
  });
  ASSERT_TRUE(replayed);
  EXPECT_NE(replayed->recorded_digest, replayed->digest);
}

TEST(Replay, of_a_killed_run_continues_to_the_end_of_the_record) {
  const std::string bytes = recorded_run(three);
  const auto replayed = replay(std::string_view{bytes}.substr(0, bytes.size() - 1), make_sum);
  ASSERT_TRUE(replayed);
  EXPECT_TRUE(replayed->truncated);
  EXPECT_FALSE(replayed->recorded_digest);
  EXPECT_EQ(replayed->inputs, 3U);
}

TEST(Replay, starts_only_with_the_configuration) {
  EXPECT_EQ(replay(written({three[1]}), make_sum).error().code, "journal.configure");
  EXPECT_EQ(replay(written({}), make_sum).error().code, "journal.configure");
  EXPECT_EQ(replay("rubbish", make_sum).error().code, "journal.magic");
}

TEST(Replay, forwards_the_reason_why_no_core_could_be_made) {
  const auto replayed =
      replay(written(three), [](const Input&) -> Result<std::unique_ptr<wire::Core>> { return fail("x.y", "no"); });
  ASSERT_FALSE(replayed);
  EXPECT_EQ(replayed.error().code, "x.y");
}

TEST(Replay, reports_damage_instead_of_a_digest) {
  std::string bytes = recorded_run(three);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] + 1);
  EXPECT_FALSE(replay(bytes, make_sum));
}

TEST(Journal, hands_each_whole_record_to_its_sink_at_once) {
  std::vector<std::size_t> sizes;
  Writer writer{[&](std::string_view piece) { sizes.push_back(piece.size()); }};
  writer.append(three[0]);
  writer.append(three[2]);
  writer.end(SimTime{9s}, "x");
  // The format's name; then 4 bytes of length, 12 fixed ones, source and payload, 4 of the checksum.
  EXPECT_THAT(sizes, ::testing::ElementsAre(8U, 4U + 12U + 6U + 17U + 4U, 4U + 12U + 4U, 4U + 12U + 1U + 4U));
}

TEST(Journal, takes_each_kind_of_input_and_no_other) {
  for (int kind = 0; kind < 255; ++kind) {
    const ReadBack back = read_all(sealed(body(static_cast<char>(kind), 0, 0, "")));
    if (kind >= 1 && kind <= 11) {
      ASSERT_EQ(back.inputs.size(), 1U) << kind;
      EXPECT_EQ(static_cast<int>(back.inputs[0].kind), kind);
    } else {
      ASSERT_TRUE(back.error) << kind;
      EXPECT_EQ(back.error->message, "unknown record kind " + std::to_string(kind));
      EXPECT_EQ(back.error->location, "offset 8");
    }
  }
}

TEST(Journal, gives_nothing_more_after_its_end_or_a_cut) {
  const std::string whole = written(three, "x");
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}}) {
    auto reader = Reader::open(std::string_view{whole}.substr(0, whole.size() - cut));
    ASSERT_TRUE(reader);
    for (std::size_t i = 0; i < three.size(); ++i) EXPECT_EQ(reader->next().value(), three[i]);
    for (int again = 0; again < 3; ++again) {
      const auto next = reader->next();
      ASSERT_TRUE(next);
      EXPECT_FALSE(next->has_value());
    }
    EXPECT_EQ(reader->truncated(), cut == 1);
    EXPECT_EQ(reader->recorded_digest().has_value(), cut == 0);
  }
}

TEST(Journal, takes_a_flag_of_0_or_1) {
  for (const char flag : {'\0', '\1'}) {
    const ReadBack back = read_all(sealed(body(2, flag, 0, "payload")));
    ASSERT_EQ(back.inputs.size(), 1U);
    EXPECT_EQ(back.inputs[0], (Input{SimTime{}, InputKind::message, "", "payload", flag == '\1'}));
  }
}

TEST(Replay, of_a_damaged_journal_does_not_reach_its_end) {
  std::string first_damaged = recorded_run(three);
  first_damaged[8 + 4 + 12] = static_cast<char>(first_damaged[8 + 4 + 12] ^ 1);
  std::string last_damaged = recorded_run(three);
  last_damaged.back() = static_cast<char>(last_damaged.back() ^ 1);
  for (const std::string& bytes : {first_damaged, last_damaged}) {
    bool reached = false;
    const auto replayed = replay(bytes, make_sum, [&](wire::Core&) { reached = true; });
    ASSERT_FALSE(replayed);
    EXPECT_EQ(replayed.error().code, "journal.crc");
    EXPECT_FALSE(reached);
  }
}

}  // namespace
}  // namespace cosiva::journal
