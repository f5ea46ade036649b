// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_column.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

constexpr std::string_view slicePattern = "slice%06T";
constexpr std::size_t maxSlices = 1'000'000;

/// The datasets of a slice.
enum Record : std::size_t { xRecord, yRecord, pxRecord, pyRecord, gammaRecord, thetaRecord, recordCount };
constexpr const char* recordNames[] = {"x", "y", "px", "py", "gamma", "theta"};

/// A slice that holds particles.
struct Slice {
    std::int64_t number = 0;  ///< from 1
    std::uint64_t begin = 0;  ///< its first row in the run
    std::uint64_t rows = 0;
    double weight = 0.0;  ///< C, of each particle
};

std::string sliceName(std::int64_t number) {
    std::string digits = std::to_string(number);
    if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
    return "/slice" + digits;
}

Result<H5Column> openColumn(const H5File& file, const std::string& path) {
    MOTE_ASSIGN_OR_RETURN(auto dataset, file.require(file.root(), path));
    return H5Column::open(file, std::move(dataset));
}

Result<double> numberAt(const H5File& file, const std::string& path) {
    MOTE_ASSIGN_OR_RETURN(const auto column, openColumn(file, path));
    if (column.rows() != 1) return corrupt(column.object().where, "is not one number");
    double value = 0.0;
    MOTE_RETURN_IF_ERROR(column.read(0, 1, &value));
    return value;
}

/// One dump: slices of the beam, one after the other.
class GenesisFile {
  public:
    static Result<GenesisFile> open(const std::filesystem::path& path, double mass, Progress& progress);

    std::uint64_t rows() const { return slices_.empty() ? 0 : slices_.back().begin + slices_.back().rows; }
    /// As SeriesSource::readRows.
    Status read(const std::vector<Column>& wanted, ParticleChunk& chunk);
    /// Gives back the datasets that are open.
    void close() { open_ = {}; }

  private:
    Status addSlice(const H5File& file, std::int64_t number, bool one4one);
    Status readPart(const Slice& slice, std::uint64_t begin, std::size_t count, std::size_t at,
                    const std::vector<Column>& wanted, ParticleChunk& chunk);
    Status load(const Slice& slice, Record record, std::uint64_t begin, std::size_t count);
    double value(Column column, const Slice& slice, std::size_t row) const;

    std::filesystem::path path_;
    std::string name_;
    double mass_ = 0.0, sliceLength_ = 0.0, sliceSpacing_ = 0.0;
    std::vector<Slice> slices_;
    std::int64_t openSlice_ = 0;
    std::array<std::optional<H5Column>, recordCount> open_;
    std::array<std::vector<double>, recordCount> values_;
};

Result<GenesisFile> GenesisFile::open(const std::filesystem::path& path, double mass, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    GenesisFile result;
    result.path_ = path;
    result.name_ = file.name();
    result.mass_ = mass;
    MOTE_ASSIGN_OR_RETURN(result.sliceLength_, numberAt(file, "/slicelength"));
    MOTE_ASSIGN_OR_RETURN(result.sliceSpacing_, numberAt(file, "/slicespacing"));
    if (!(result.sliceLength_ > 0.0) || !(result.sliceSpacing_ > 0.0) ||
        !std::isfinite(result.sliceLength_ + result.sliceSpacing_)) {
        return corrupt(result.name_, "has slices without length (slicelength, slicespacing)");
    }
    MOTE_ASSIGN_OR_RETURN(const auto one4one, file.find(file.root(), "/one4one"));
    double each = 0.0;
    if (one4one) {
        MOTE_ASSIGN_OR_RETURN(each, numberAt(file, "/one4one"));
    }
    MOTE_ASSIGN_OR_RETURN(const auto names, file.children(file.root()));
    std::vector<std::int64_t> numbers;
    for (const std::string& name : names) {
        if (const auto number = matchIteration(slicePattern, name)) numbers.push_back(*number);
    }
    std::sort(numbers.begin(), numbers.end());
    for (const std::int64_t number : numbers) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled while a run was opened"};
        MOTE_RETURN_IF_ERROR(result.addSlice(file, number, each != 0.0));
    }
    return result;
}

/// Slices without current hold nothing: Genesis leaves what it likes in them.
Status GenesisFile::addSlice(const H5File& file, std::int64_t number, bool one4one) {
    const std::string group = sliceName(number);
    MOTE_ASSIGN_OR_RETURN(const auto dataset, file.find(file.root(), group + "/gamma"));
    if (!dataset) return success();
    Slice slice{number, rows(), 0, 0.0};
    for (const char* record : recordNames) {
        MOTE_ASSIGN_OR_RETURN(const auto column, openColumn(file, group + "/" + record));
        if (record == recordNames[0]) slice.rows = column.rows();
        if (column.rows() != slice.rows) {
            return corrupt(column.object().where, "has " + std::to_string(column.rows()) +
                                                      " values where other columns have " +
                                                      std::to_string(slice.rows));
        }
    }
    if (slice.rows == 0) return success();
    MOTE_ASSIGN_OR_RETURN(const auto current, numberAt(file, group + "/current"));
    slice.weight =
        one4one ? elementaryCharge : current * sliceSpacing_ / speedOfLight / static_cast<double>(slice.rows);
    if (!(slice.weight > 0.0) || !std::isfinite(slice.weight)) return success();
    slices_.push_back(slice);
    return success();
}

Status GenesisFile::read(const std::vector<Column>& wanted, ParticleChunk& chunk) {
    const std::uint64_t begin = chunk.begin;
    auto slice = std::upper_bound(slices_.begin(), slices_.end(), begin,
                                  [](std::uint64_t row, const Slice& one) { return row < one.begin; });
    for (std::size_t done = 0; done < chunk.size; ++slice) {
        const Slice& one = *(slice - 1);  // the first one begins at row 0
        const std::uint64_t first = begin + done - one.begin;
        const auto rows =
            static_cast<std::size_t>(std::min<std::uint64_t>(one.rows - first, chunk.size - done));
        MOTE_RETURN_IF_ERROR(readPart(one, first, rows, done, wanted, chunk));
        done += rows;
    }
    return success();
}

Status GenesisFile::load(const Slice& slice, Record record, std::uint64_t begin, std::size_t count) {
    if (openSlice_ != slice.number) close();
    openSlice_ = slice.number;
    if (!open_[record]) {
        MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path_));
        MOTE_ASSIGN_OR_RETURN(open_[record],
                              openColumn(file, sliceName(slice.number) + "/" + recordNames[record]));
    }
    values_[record].resize(count);
    return open_[record]->read(begin, count, values_[record].data());
}

/// The datasets from which a column is computed.
std::vector<Record> recordsOf(Column column) {
    switch (column) {
        case Column::x:
            return {xRecord};
        case Column::y:
            return {yRecord};
        case Column::z:
            return {thetaRecord};
        case Column::px:
            return {pxRecord};
        case Column::py:
            return {pyRecord};
        case Column::pz:
            return {pxRecord, pyRecord, gammaRecord};
        case Column::t:
        case Column::weight:
        case Column::id:
            break;
    }
    return {};
}

double GenesisFile::value(Column column, const Slice& slice, std::size_t row) const {
    switch (column) {
        case Column::x:
            return values_[xRecord][row];
        case Column::y:
            return values_[yRecord][row];
        case Column::z:
            return static_cast<double>(slice.number - 1) * sliceSpacing_ +
                   values_[thetaRecord][row] / radiansPerTurn * sliceLength_;
        case Column::px:
            return values_[pxRecord][row] * mass_;
        case Column::py:
            return values_[pyRecord][row] * mass_;
        case Column::pz: {
            const double gamma = values_[gammaRecord][row], px = values_[pxRecord][row],
                         py = values_[pyRecord][row];
            return std::sqrt((gamma - 1.0) * (gamma + 1.0) - px * px - py * py) * mass_;
        }
        case Column::weight:
            return slice.weight;
        case Column::t:
        case Column::id:
            break;
    }
    return 0.0;
}

Status GenesisFile::readPart(const Slice& slice, std::uint64_t begin, std::size_t count, std::size_t at,
                             const std::vector<Column>& wanted, ParticleChunk& chunk) {
    std::array<bool, recordCount> loaded{};
    for (const Column column : wanted) {
        for (const Record record : recordsOf(column)) {
            if (!loaded[record]) MOTE_RETURN_IF_ERROR(load(slice, record, begin, count));
            loaded[record] = true;
        }
    }
    for (const Column column : wanted) {
        if (column == Column::id) continue;
        for (std::size_t i = 0; i < count; ++i) chunk[column][at + i] = value(column, slice, i);
    }
    return success();
}

class GenesisSource : public SeriesSource {
  public:
    GenesisSource(double mass, Progress& progress) : SeriesSource("genesis4", progress), mass_(mass) {}

    double mass() const override { return mass_; }
    std::string species() const override { return mass_ == electronMass ? "electron" : ""; }
    double particleCharge() const override { return mass_ == electronMass ? -elementaryCharge : 0.0; }
    std::string weightUnit() const override { return "C"; }

  protected:
    Status addFile(const std::filesystem::path& path) override {
        MOTE_ASSIGN_OR_RETURN(auto file, GenesisFile::open(path, mass_, progress_));
        steps_.push_back(stepOf(path, file.rows()));
        files_.push_back(std::move(file));
        return success();
    }
    bool hasEverywhere(Column column) const override { return column != Column::t && column != Column::id; }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override {
        if (open_ != step) files_[open_].close();
        open_ = step;
        return files_[step].read(wanted, chunk);
    }

  private:
    double mass_;
    std::vector<GenesisFile> files_;
    std::size_t open_ = 0;
};

}  // namespace

extern const ParticleReader genesisReader;
constinit const ParticleReader genesisReader{
    "genesis4", "HDF5 with slicelength, slicespacing and beamletsize", ParticleReader::Kind::hdf5,
    [](const AskedFile& file) -> Result<bool> {
        for (const char* name : {"/slicelength", "/slicespacing", "/beamletsize"}) {
            const auto dataset = file.hdf5->find(file.hdf5->root(), name);
            if (!dataset || !*dataset || (*dataset)->group) return false;
        }
        return true;
    },
    [](const AskedRun& run, Progress& progress) {
        return openSeries(std::make_unique<GenesisSource>(run.mass > 0.0 ? run.mass : electronMass, progress),
                          inOrder(run.files));
    }};

}  // namespace mote::prep
