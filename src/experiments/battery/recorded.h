#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/battery/procedure.h"

/// Battery tests that were made before, with CoSiVA or elsewhere: evaluated like own tests.
namespace cosiva::experiments {

/// The columns of a table; for an empty name the usual names are tried.
struct RecordedColumns {
  std::string time;     ///< duration of a run; its unit is the end of its name: _second, _minute, _hour
  std::string battery;  ///< without any, each row is a separate battery
  std::string vehicle;  ///< or the tester's channel
  std::string run;      ///< without any, a battery's rows are its runs in order
};

/// The runs of one test.
struct RecordedSeries {
  std::string name;  ///< the value of the table's column `series`, or the file
  std::size_t batteries{};
  std::vector<BatteryRun> records;  ///< without curves
};

/// Reads a table with a header and a row for each run: how long a battery lasted, optionally which battery, on which
/// vehicle or tester channel, in which run, in which `series`, and what ended it (`stop`: floor, cut-off, fault,
/// operator, lost). Fails ("recorded.…") naming file and line: recorded.column, recorded.number, recorded.stop, and
/// recorded.twice where one battery has the same run twice.
[[nodiscard]] Result<std::vector<RecordedSeries>> read_recorded(std::string_view csv, const std::string& origin,
                                                                const RecordedColumns& columns = {});
/// Combines result files of `cosiva battery`, of any number of tests, into one: equal ids are the same battery.
/// @param texts  each a file's text and its name
struct RecordedFile {
  std::string text;
  std::string origin;
};
[[nodiscard]] Result<RecordedSeries> read_results(const std::vector<RecordedFile>& files);

/// Evaluates the series as if a battery's first run had been ended at this time by another cause than the battery,
/// which would have lasted longer. Fails ("recorded.failed") where there is no such battery, or its run was not longer.
[[nodiscard]] Result<void> end_early(RecordedSeries& series, const std::string& battery_id, double after_s);

}  // namespace cosiva::experiments
