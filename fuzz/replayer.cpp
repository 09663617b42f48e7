// Replaces libFuzzer where the compiler has none: runs the corpus, then mutations of it, through one target.
//
//     fuzz_vda5050 CORPUS [MUTATIONS [SEED [FIRST]]]
//
// A crash names seed and mutation; FIRST skips to it.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "corpus.h"
#include "mutate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

// The text that a signal handler may print, prepared before each run.
char where[128];
volatile std::sig_atomic_t where_length = 0;

extern "C" void on_crash(int signal) {
  if (::write(STDERR_FILENO, where, static_cast<std::size_t>(where_length)) < 0) std::_Exit(2);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void run(const std::string& input) {
  (void)LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s CORPUS [MUTATIONS [SEED [FIRST]]]\n", argv[0]);
    return 2;
  }
  const auto number = [&](int i, unsigned long long otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const auto mutations = number(2, 20'000);
  const auto seed = number(3, 1);
  const auto first = number(4, 0);
  const std::vector<std::string> corpus = cosiva::fuzz::read_corpus(argv[1]);
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no corpus\n", argv[1]);
    return 2;
  }
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS}) std::signal(signal, on_crash);

  for (const std::string& input : corpus) run(input);
  cosiva::fuzz::Mutator mutator{seed, corpus};
  for (unsigned long long i = 0; i < mutations; ++i) {
    const std::string& input = mutator.next();
    if (i < first) continue;
    where_length =
        std::snprintf(where, sizeof where, "crashed at: %s CORPUS %llu %llu %llu\n", "fuzz", mutations, seed, i);
    run(input);
  }
  std::printf("%zu corpus files and %llu mutations of them (seed %llu)\n", corpus.size(), mutations, seed);
  return 0;
}
