// Makes the database in memory and returns its bytes; files are written elsewhere.
#include "cosiva/experiments/positioning/campaign/table_sqlite.h"

#include <sqlite3.h>

#include <memory>

namespace cosiva::experiments {
namespace {

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, Close>;
using Statement = std::unique_ptr<sqlite3_stmt, Close>;

tl::unexpected<Error> refuse(sqlite3* database) {
  return fail("sqlite", std::string("the database cannot be made: ") +
                            (database != nullptr ? sqlite3_errmsg(database) : "no memory"));
}

std::string quoted_name(const std::string& name) { return '"' + name + '"'; }

std::string_view type_of(ResultTable::Column::Kind kind) {
  switch (kind) {
    case ResultTable::Column::Kind::whole: return "INTEGER";
    case ResultTable::Column::Kind::number: return "REAL";
    case ResultTable::Column::Kind::text: return "TEXT";
  }
  return "TEXT";
}

Result<void> run(sqlite3* database, const std::string& statement) {
  if (sqlite3_exec(database, statement.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return refuse(database);
  return {};
}

int bind_value(sqlite3_stmt* statement, int at, const TableValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return sqlite3_bind_int64(statement, at, *whole);
  // SQLite stores a NaN as NULL.
  if (const auto* number = std::get_if<double>(&value)) return sqlite3_bind_double(statement, at, *number);
  // The text lives until the statement is reset; SQLITE_TRANSIENT would need a cast of its own.
  const auto& text = std::get<std::string>(value);
  return sqlite3_bind_text64(statement, at, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
}

Result<void> fill(sqlite3* database, const ResultTable& table) {
  std::string columns;
  std::string positions;
  for (const ResultTable::Column& column : table.columns) {
    columns.append(columns.empty() ? "" : ", ")
        .append(quoted_name(column.name))
        .append(" ")
        .append(type_of(column.kind));
    positions += positions.empty() ? "?" : ", ?";
  }
  if (auto made = run(database, "CREATE TABLE " + quoted_name(table.name) + " (" + columns + ")"); !made) return made;
  const std::string insert = "INSERT INTO " + quoted_name(table.name) + " VALUES (" + positions + ")";
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database, insert.c_str(), -1, &raw, nullptr) != SQLITE_OK) return refuse(database);
  const Statement statement{raw};
  for (std::size_t row = 0; row < table.rows; ++row) {
    std::vector<TableValue> values;
    for (const ResultTable::Column& column : table.columns) values.push_back(column.value(row));
    for (std::size_t c = 0; c < values.size(); ++c)
      if (bind_value(raw, static_cast<int>(c) + 1, values[c]) != SQLITE_OK) return refuse(database);
    if (sqlite3_step(raw) != SQLITE_DONE || sqlite3_reset(raw) != SQLITE_OK) return refuse(database);
  }
  return {};
}

}  // namespace

Result<std::string> to_sqlite(const std::vector<ResultTable>& tables) {
  sqlite3* raw = nullptr;
  const int opened = sqlite3_open(":memory:", &raw);
  const Database database{raw};
  if (opened != SQLITE_OK) return refuse(raw);
  if (auto begun = run(raw, "BEGIN"); !begun) return tl::unexpected(begun.error());
  for (const ResultTable& table : tables)
    if (auto filled = fill(raw, table); !filled) return tl::unexpected(filled.error());
  if (auto ended = run(raw, "COMMIT"); !ended) return tl::unexpected(ended.error());
  sqlite3_int64 size = 0;
  struct Free {
    void operator()(unsigned char* bytes) const { sqlite3_free(bytes); }
  };
  const std::unique_ptr<unsigned char, Free> bytes{sqlite3_serialize(raw, "main", &size, 0)};
  if (bytes == nullptr) return refuse(nullptr);
  return std::string(reinterpret_cast<const char*>(bytes.get()), static_cast<std::size_t>(size));
}

}  // namespace cosiva::experiments
