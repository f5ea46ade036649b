// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "server/numbers/coarse_notes.h"
#include "server/numbers/query_parts.h"
#include "storage/numbers/column_pieces.h"

namespace mote::server {
namespace {

constexpr std::uint64_t pieceBytes = std::uint64_t{4} << 20;

class ColumnsPart final : public QueryPart {
  public:
    explicit ColumnsPart(const proto::ColumnsQuery& query)
        : names_(query.names().begin(), query.names().end()),
          begin_(query.begin()),
          count_(query.count()),
          byId_(query.by_id()) {}

    Status answer(const StepQuestion& question, QueryAnswer& answer) override {
        MOTE_ASSIGN_OR_RETURN(const auto numbers, question.numbers());
        MOTE_ASSIGN_OR_RETURN(const auto reader, storage::ColumnReader::make(numbers, names_));
        auto& message = *answer.message.mutable_columns();
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(2 * pieceBytes));
        storage::ColumnPiece piece;
        if (byId_) {
            MOTE_ASSIGN_OR_RETURN(const auto ids, question.ids());
            const auto begin = std::min<std::uint64_t>(begin_, ids->size());
            const auto rows = std::min({ids->size() - begin, reader.rowsIn(pieceBytes), count()});
            MOTE_ASSIGN_OR_RETURN(piece,
                                  reader.readIds(std::span(*ids).subspan(begin, rows), question.cancelled()));
            piece.next = begin + rows;
            piece.end = piece.next == ids->size();
            message.set_total(ids->size());
        } else {
            MOTE_ASSIGN_OR_RETURN(const auto chosen, question.chosen());
            MOTE_ASSIGN_OR_RETURN(piece, reader.read(begin_, count(), reader.rowsIn(pieceBytes), chosen.get(),
                                                     question.cancelled()));
        }
        numbers.columns->check();
        for (const auto& name : names_) message.add_names(name);
        for (const auto& unit : reader.units()) message.add_units(unit);
        message.set_count(piece.rows);
        message.set_next(piece.next);
        message.set_end(piece.end);
        addNotes(*numbers.columns, piece, answer.message);
        answer.payload = std::move(piece.bytes);
        answer.memory.shrink(answer.payload.size());
        return success();
    }

  private:
    void addNotes(const storage::ParticleColumns& columns, const storage::ColumnPiece& piece,
                  proto::Answer& message) const {
        std::vector<double> values(piece.rows);
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (names_[i] == "id" || values.empty()) continue;
            const std::size_t bytes = values.size() * sizeof(double);
            std::memcpy(values.data(), piece.bytes.data() + i * bytes, bytes);
            for (auto& note : notesOfValues(columns, names_[i], values)) message.add_notes(std::move(note));
        }
    }

    std::uint64_t count() const { return count_ == 0 ? ~std::uint64_t{0} : count_; }

    const std::vector<std::string> names_;
    const std::uint64_t begin_, count_;
    const bool byId_;
};

}  // namespace

MadePart columnsPart(const proto::ColumnsQuery& query) {
    if (query.names().empty())
        return Error{ErrorCode::invalidArgument, "names", "at least one column is asked for"};
    MOTE_RETURN_IF_ERROR(checkNames(query.names()));
    return MadePart(std::make_unique<ColumnsPart>(query));
}

}  // namespace mote::server
