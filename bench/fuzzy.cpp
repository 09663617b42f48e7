// A fuzzy decision: many at once, one by one, and fuzzylite 6 on the same rules and the same inputs in the same run.
// `ratio` is how many times faster than fuzzylite a row is; compare the rows of one run.
#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/fuzzy/oracle/test_fuzzylite.h"
#include "cosiva/fuzzy/rule_base.h"

namespace {

using namespace cosiva;

/// Three inputs, fifteen rules: a common size of such bases.
constexpr const char* small_rules = R"(Engine: small
InputVariable: gap
  range: 0.0 10.0
  lock-range: true
  term: close Trapezoid 0.0 0.0 1.0 3.0
  term: near Triangle 1.0 3.0 5.0
  term: middle Triangle 3.0 5.0 7.5
  term: far Trapezoid 5.0 7.5 10.0 10.0
InputVariable: closing
  range: -2.0 2.0
  lock-range: true
  term: opening Trapezoid -2.0 -2.0 -1.0 0.0
  term: steady Triangle -1.0 0.0 1.0
  term: closing Trapezoid 0.0 1.0 2.0 2.0
InputVariable: congestion
  range: 0.0 1.0
  lock-range: true
  term: low Trapezoid 0.0 0.0 0.2 0.5
  term: high Trapezoid 0.2 0.5 1.0 1.0
OutputVariable: factor
  range: 0.0 1.0
  defuzzifier: WeightedAverage TakagiSugeno
  default: 0.0
  term: stop Constant 0.0
  term: slow Linear 0.02 -0.05 -0.1 0.2
  term: cruise Linear 0.03 -0.05 -0.1 0.45
  term: full Constant 1.0
RuleBlock: rules
  conjunction: AlgebraicProduct
  disjunction: Maximum
  rule: if gap is close and closing is closing then factor is stop
  rule: if gap is close and closing is steady then factor is stop
  rule: if gap is close and closing is opening then factor is slow
  rule: if gap is near and closing is closing then factor is stop
  rule: if gap is near and closing is steady and congestion is low then factor is slow
  rule: if gap is near and closing is steady and congestion is high then factor is stop
  rule: if gap is near and closing is opening then factor is cruise
  rule: if gap is middle and closing is closing then factor is slow
  rule: if gap is middle and closing is steady and congestion is low then factor is cruise
  rule: if gap is middle and closing is steady and congestion is high then factor is slow
  rule: if gap is middle and closing is opening and congestion is low then factor is full
  rule: if gap is middle and closing is opening and congestion is high then factor is cruise
  rule: if gap is far and closing is closing then factor is cruise
  rule: if gap is far and congestion is low then factor is full
  rule: if gap is far and congestion is high then factor is cruise
)";

constexpr std::size_t questions = 4096;

using Clock = std::chrono::steady_clock;

/// One rule base, CoSiVA's and fuzzylite's, and its inputs by variable.
struct Subject {
  explicit Subject(std::string rules) : text{std::move(rules)}, rule_base{*fuzzy::RuleBase::read(text, "bench")} {
    Random random{1, "questions"};
    for (const fuzzy::Variable& input : rule_base.engine().inputs) {
      columns.emplace_back(questions);
      for (double& x : columns.back()) x = random.uniform(input.minimum, input.maximum);
    }
    responses.assign(rule_base.engine().outputs.size(), std::vector<double>(questions));
  }

  template <typename Evaluate>
  void send_request(std::size_t k, Evaluate evaluate) {
    std::array<double, 16> question{};
    std::array<double, 16> response{};
    for (std::size_t i = 0; i < columns.size(); ++i) question[i] = columns[i][k];
    evaluate(std::span(question).first(columns.size()), std::span(response).first(responses.size()));
    benchmark::DoNotOptimize(response);
  }

  std::string text;
  fuzzy::RuleBase rule_base;
  std::vector<std::vector<double>> columns;
  std::vector<std::vector<double>> responses;
};

std::string agent_rules() {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  return text.str();
}

Subject& subject(std::int64_t which) {
  static Subject small{small_rules};
  static Subject agent{agent_rules()};
  return which == 0 ? small : agent;
}

/// fuzzylite's time, measured in this run before the rows that are compared with it.
double fuzzylite_ns(std::int64_t which) {
  static std::array<double, 2> known{};
  double& ns = known[static_cast<std::size_t>(which)];
  if (ns > 0.0) return ns;
  Subject& requested = subject(which);
  fuzzy::Fuzzylite theirs{requested.text};
  const auto start = Clock::now();
  std::size_t count = 0;
  while (Clock::now() - start < std::chrono::milliseconds{100}) {
    for (std::size_t k = 0; k < 64; ++k)
      requested.send_request((count + k) % questions, [&](auto in, auto out) { theirs.evaluate(in, out); });
    count += 64;
  }
  ns = std::chrono::duration<double, std::nano>(Clock::now() - start).count() / static_cast<double>(count);
  return ns;
}

/// Time per decision, and how many times faster than fuzzylite that is.
/// @param start  of the loop
void report(benchmark::State& state, Clock::time_point start, std::size_t decisions_each) {
  const double elapsed_ns = std::chrono::duration<double, std::nano>(Clock::now() - start).count();
  const auto decisions = state.iterations() * static_cast<std::int64_t>(decisions_each);
  state.SetItemsProcessed(decisions);
  using benchmark::Counter;
  const auto count = static_cast<double>(decisions);
  state.counters["per_decision"] = Counter(count, Counter::kIsRate | Counter::kInvert);
  state.counters["ratio"] = fuzzylite_ns(state.range(0)) * count / elapsed_ns;
}

void BM_many_at_once(benchmark::State& state) {
  Subject& requested = subject(state.range(0));
  const std::vector<std::span<const double>> inputs(requested.columns.begin(), requested.columns.end());
  const std::vector<std::span<double>> outputs(requested.responses.begin(), requested.responses.end());
  const auto start = Clock::now();
  for (auto _ : state) {
    requested.rule_base.evaluate(inputs, outputs);
    benchmark::ClobberMemory();
  }
  report(state, start, questions);
}

void BM_one_by_one(benchmark::State& state) {
  Subject& requested = subject(state.range(0));
  std::size_t k = 0;
  const auto start = Clock::now();
  for (auto _ : state) {
    requested.send_request(k, [&](auto in, auto out) { requested.rule_base.evaluate(in, out); });
    k = (k + 1) % questions;
  }
  report(state, start, 1);
}

void BM_fuzzylite(benchmark::State& state) {
  Subject& requested = subject(state.range(0));
  fuzzy::Fuzzylite theirs{requested.text};
  std::size_t k = 0;
  const auto start = Clock::now();
  for (auto _ : state) {
    requested.send_request(k, [&](auto in, auto out) { theirs.evaluate(in, out); });
    k = (k + 1) % questions;
  }
  report(state, start, 1);
}

// 0: three inputs and fifteen rules; 1: the agent's own, rules/agent.fll.
BENCHMARK(BM_many_at_once)->ArgName("agent")->Arg(0)->Arg(1);
BENCHMARK(BM_one_by_one)->ArgName("agent")->Arg(0)->Arg(1);
BENCHMARK(BM_fuzzylite)->ArgName("agent")->Arg(0)->Arg(1);

}  // namespace

// fuzzylite's library has a main of its own, which would take precedence over the benchmark library's.
BENCHMARK_MAIN();
