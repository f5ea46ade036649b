// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <memory>
#include <span>

#include "client/shared/number_text.h"
#include "client/shared/part_file.h"
#include "client/stats/export_particles.h"
#include "client/stats/npy.h"

namespace mote::client {
namespace {

/// Where rows go. One owner.
class RowFile {
  public:
    virtual ~RowFile() = default;
    /// The rows of a piece. Errors: those of the system.
    virtual Status append(const StepColumns& piece) = 0;
    virtual Status publish() = 0;
};

/// What each row holds.
struct RowShape {
    bool step = false;  ///< first of all, where there are several
    std::vector<std::string> names;
    std::vector<std::string> headings;  ///< by name, with its unit: "x [m]"

    bool isId(std::size_t column) const { return names[column] == "id"; }
};

class NpyRowFile final : public RowFile {
  public:
    static Result<std::unique_ptr<RowFile>> create(const std::filesystem::path& path, const RowShape& shape) {
        std::vector<NpyField> fields;
        if (shape.step) fields.push_back({"step", "<u8"});
        for (std::size_t i = 0; i < shape.names.size(); ++i) {
            const bool titled = shape.headings[i] != shape.names[i];
            fields.push_back(
                {shape.names[i], shape.isId(i) ? "<u8" : "<f8", titled ? shape.headings[i] : ""});
        }
        MOTE_ASSIGN_OR_RETURN(auto rows, NpyRows::create(path, fields));
        return std::unique_ptr<RowFile>(new NpyRowFile(std::move(rows), shape.step));
    }

    Status append(const StepColumns& piece) override {
        std::vector<std::uint64_t> words;
        words.reserve(piece.count * (piece.words.size() + 1));
        for (std::uint64_t row = 0; row < piece.count; ++row) {
            if (step_) words.push_back(piece.step);
            for (const auto& column : piece.words) words.push_back(column[row]);
        }
        return rows_.append(words);
    }
    Status publish() override { return rows_.publish(); }

  private:
    NpyRowFile(NpyRows rows, bool step) : rows_(std::move(rows)), step_(step) {}
    NpyRows rows_;
    const bool step_;
};

class CsvRowFile final : public RowFile {
  public:
    static Result<std::unique_ptr<RowFile>> create(const std::filesystem::path& path, const RowShape& shape) {
        MOTE_ASSIGN_OR_RETURN(auto part, PartFile::create(path));
        std::unique_ptr<CsvRowFile> file(new CsvRowFile(std::move(part), shape));
        std::string head = shape.step ? "step" : "";
        for (const auto& name : shape.headings) head += (head.empty() ? "" : ",") + csvField(name);
        MOTE_RETURN_IF_ERROR(file->write(head + "\n"));
        return std::unique_ptr<RowFile>(std::move(file));
    }

    Status append(const StepColumns& piece) override {
        std::string text;
        for (std::uint64_t row = 0; row < piece.count; ++row) {
            if (shape_.step) text += fmt::format("{},", piece.step);
            for (std::size_t i = 0; i < piece.words.size(); ++i) {
                const auto word = piece.words[i][row];
                if (i > 0) text += ',';
                text +=
                    shape_.isId(i) ? fmt::format("{}", word) : exactNumber(std::bit_cast<double>(word), "");
            }
            text += '\n';
        }
        return write(text);
    }
    Status publish() override { return part_->publish(); }

  private:
    CsvRowFile(std::unique_ptr<PartFile> part, RowShape shape)
        : part_(std::move(part)), shape_(std::move(shape)) {}
    Status write(const std::string& text) { return part_->append(bytesOf(std::span<const char>(text))); }

    std::unique_ptr<PartFile> part_;
    const RowShape shape_;
};

/// All columns of the dataset, and its ids first.
std::vector<std::string> allColumns(const proto::ParticlesManifest& manifest) {
    std::vector<std::string> names;
    if (manifest.ids()) names.emplace_back("id");
    for (const auto& column : manifest.columns()) names.push_back(column.name());
    return names;
}

/// A weight's unit is said even where it is 1: whoever reads the file must not guess.
std::string headingOf(const std::string& name, const AskedRun& run, const ColumnUnits& units) {
    if (name == "weight") return withUnit(name, run.manifest().weight_unit(), true);
    return withUnit(name, unitOfColumn(name, units));
}

Status exportStep(AskedRun& run, std::size_t step, const std::vector<std::string>& names, RowFile& file) {
    auto query = run.query();
    query.set_steps(fmt::format("{}:{}:1", step, step));
    auto& asked = *query.mutable_columns();
    asked.mutable_names()->Assign(names.begin(), names.end());
    while (true) {
        std::uint64_t next = 0;
        bool end = false;
        MOTE_RETURN_IF_ERROR(run.ask(query, {step}, [&](const QueryAnswer& answer) -> Status {
            MOTE_ASSIGN_OR_RETURN(const auto piece, columnsOf(answer, asked));
            next = piece.next;
            end = piece.end;
            return file.append(piece);
        }));
        if (end) return success();
        asked.set_begin(next);
    }
}

}  // namespace

Status exportRows(const StatsOptions& options, AskedRun& run) {
    RowShape shape;
    shape.step = run.steps().size() > 1;
    shape.names = options.columns.empty() ? allColumns(run.manifest()) : options.columns;
    const auto units = run.units();
    for (const auto& name : shape.names) shape.headings.push_back(headingOf(name, run, units));
    if (shape.names.empty()) {
        return Error{
            ErrorCode::notFound, run.dataset(),
            "was made without columns: make it again from its source (mote-prep particles) to have them"};
    }
    const bool npy = options.exported.extension() == ".npy";
    MOTE_ASSIGN_OR_RETURN(const auto file, npy ? NpyRowFile::create(options.exported, shape)
                                               : CsvRowFile::create(options.exported, shape));
    for (const auto step : run.steps()) MOTE_RETURN_IF_ERROR(exportStep(run, step, shape.names, *file));
    return file->publish();
}

}  // namespace mote::client
