// SPDX-License-Identifier: GPL-3.0-or-later
//
// SqlStatement: one prepared statement of SQLite, bound from left to right. A failed preparation shows in
// step(), and in the database's error. Lives no longer than the database.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>

namespace mote::server {

class SqlStatement {
  public:
    SqlStatement(sqlite3* database, const char* sql) {
        prepared_ = sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr);
    }
    ~SqlStatement() { sqlite3_finalize(statement_); }
    SqlStatement(const SqlStatement&) = delete;
    SqlStatement& operator=(const SqlStatement&) = delete;

    SqlStatement& bind(std::int64_t value) {
        sqlite3_bind_int64(statement_, ++bound_, value);
        return *this;
    }
    SqlStatement& bind(double value) {
        sqlite3_bind_double(statement_, ++bound_, value);
        return *this;
    }
    SqlStatement& bind(const std::string& text) {
        sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
        return *this;
    }

    /// SQLITE_ROW, SQLITE_DONE or an error's code.
    int step() { return prepared_ == SQLITE_OK ? sqlite3_step(statement_) : prepared_; }

    std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
    double real(int column) const { return sqlite3_column_double(statement_, column); }
    std::string text(int column) const {
        const auto* data = sqlite3_column_text(statement_, column);
        const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
        return data ? std::string(reinterpret_cast<const char*>(data), size) : std::string();
    }

  private:
    sqlite3_stmt* statement_ = nullptr;
    int prepared_ = SQLITE_OK;
    int bound_ = 0;
};

}  // namespace mote::server
