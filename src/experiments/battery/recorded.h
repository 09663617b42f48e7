#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/battery/procedure.h"

/// Tests of batteries that were made before, here or by others: what is said of ours is said of theirs.
namespace cosiva::experiments {

/// Which column of a table holds what; an empty name is looked for among the usual ones.
struct RecordedColumns {
  std::string time;     ///< how long it lasted; its unit is the end of its name: _second, _minute, _hour
  std::string battery;  ///< without any, each row is a battery of its own
  std::string vehicle;  ///< or the tester's channel
  std::string run;      ///< without any, a battery's rows are its runs in their order
};

/// Runs that belong together.
struct RecordedSeries {
  std::string name;  ///< what the table's column `series` says, or the file
  std::size_t batteries{};
  std::vector<BatteryRun> records;  ///< with curves of none
};

/// A table with a header and a row for each run: how long a battery lasted, optionally which battery, on which vehicle
/// or tester channel, in which run, in which `series`, and what ended it (`stop`: floor, cut-off, fault, operator,
/// lost). Fails ("recorded.…") naming file and line: recorded.column, recorded.number, recorded.stop, and
/// recorded.twice where one battery has the same run twice.
[[nodiscard]] Result<std::vector<RecordedSeries>> read_recorded(std::string_view csv, const std::string& origin,
                                                                const RecordedColumns& columns = {});
/// Result files of `cosiva battery`, of any number of tests, as one: a battery is the same where its id is.
/// @param texts  each a file's text and its name
struct RecordedFile {
  std::string text;
  std::string origin;
};
[[nodiscard]] Result<RecordedSeries> read_results(const std::vector<RecordedFile>& files);

/// As if a battery's first run had been ended at this time by something else than the battery, which would have gone
/// on. Fails ("recorded.failed") where there is no such battery, or it lasted no longer than that.
[[nodiscard]] Result<void> end_early(RecordedSeries& series, const std::string& battery_id, double after_s);

}  // namespace cosiva::experiments
