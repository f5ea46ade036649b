// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/sdds/sdds_columns.h"
#include "preprocess/readers/sdds/sdds_header.h"
#include "preprocess/readers/sdds/sdds_pages.h"
#include "preprocess/readers/series_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t rowsPerPass = 1u << 16;

/// The places of parameters in SddsParameters.
enum Parameter : std::size_t { charge, pCentral, place, stepNumber, pass, centralTime };

class SddsSource : public SeriesSource {
  public:
    SddsSource(std::string format, double mass, Progress& progress)
        : SeriesSource(std::move(format), progress), mass_(mass) {}

    double mass() const override { return files_.front().columns.mass(); }
    std::string weightUnit() const override { return has(Column::weight) ? "C" : ""; }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    Status finish() override;
    bool hasEverywhere(Column column) const override;
    std::vector<SourceRecord> recordsEverywhere() const override;
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    struct File {
        SddsColumns columns;
        std::unique_ptr<SddsPages> pages;
        std::optional<std::int64_t> number;  // of its name
    };
    struct Page {
        std::size_t file = 0, page = 0;
        double weight = 0.0;  // of each particle, C; 0: not known
        std::optional<double> meanTime;
    };

    const SddsParameters& parameters(const Page& page) const {
        return files_[page.file].pages->pages()[page.page].parameters;
    }
    bool numberBy(Parameter parameter);
    void addPage(const File& file, std::size_t page, const std::string& name);
    Result<double> meanTime(Page& page);

    double mass_;
    std::vector<File> files_;
    std::vector<Page> pages_;  // by step
    SddsRows rows_;
};

constexpr Column coordinates[] = {Column::x, Column::y, Column::z, Column::px, Column::py, Column::pz};

/// When the step's particles pass its place, s: as the file says, else as long as light-like motion of the
/// central momentum takes from the beginning.
double timeOf(const SddsParameters& values) {
    if (std::isfinite(values[centralTime])) return values[centralTime];
    const double gammaBeta = values[pCentral];
    const double time = values[place] * std::sqrt(1.0 + gammaBeta * gammaBeta) / (gammaBeta * speedOfLight);
    return std::isfinite(time) ? time : 0.0;
}

Status SddsSource::addFile(const std::filesystem::path& path) {
    const bool hdf5 = format() == "elegant";
    MOTE_ASSIGN_OR_RETURN(const auto header, hdf5 ? readSddsHdf5Header(path) : SddsHeader::read(path));
    const std::string name = path.filename().string();
    MOTE_ASSIGN_OR_RETURN(auto columns, SddsColumns::of(header, mass_, name));
    if (std::none_of(std::begin(coordinates), std::end(coordinates),
                     [&](Column column) { return columns.has(column); })) {
        return unsupported(name,
                           "is SDDS without any of the columns x, y, z, px, py, pz of particles: statistics "
                           "or optics (as OPAL's .stat, elegant's .sig and .twi)");
    }
    auto pages = hdf5           ? openSddsHdf5(path, header, progress_)
                 : header.ascii ? openSddsAscii(path, header, progress_)
                                : openSddsBinary(path, header, progress_);
    if (!pages) return pages.error();
    if ((*pages)->pages().empty()) {
        return corrupt(
            name, "ends at its header, at byte " + std::to_string(header.dataOffset) + ": it has no page");
    }
    if (!files_.empty() && columns.mass() != files_.front().columns.mass()) {
        return invalid(name, "has particles of another mass than the first file");
    }
    files_.push_back({std::move(columns), std::move(*pages), fileNumber(path)});
    for (std::size_t i = 0; i < files_.back().pages->pages().size(); ++i) addPage(files_.back(), i, name);
    return success();
}

void SddsSource::addPage(const File& file, std::size_t page, const std::string& name) {
    const SddsPage& found = file.pages->pages()[page];
    Page entry{files_.size() - 1, page, 0.0, std::nullopt};
    const double total = std::abs(found.parameters[charge]) * file.columns.chargeFactor();
    if (found.rows > 0 && total > 0.0 && std::isfinite(total))
        entry.weight = total / static_cast<double>(found.rows);
    pages_.push_back(entry);
    steps_.push_back({name, static_cast<std::int64_t>(steps_.size()), timeOf(found.parameters), found.rows});
}

/// Numbers the steps by a parameter where it grows from step to step.
bool SddsSource::numberBy(Parameter parameter) {
    std::vector<std::int64_t> numbers;
    for (const Page& page : pages_) {
        const double value = parameters(page)[parameter];
        if (!(value >= 0.0 && value < 9e15) || value != std::floor(value)) return false;
        numbers.push_back(static_cast<std::int64_t>(value));
        if (numbers.size() > 1 && numbers.back() <= numbers[numbers.size() - 2]) return false;
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) steps_[i].iteration = numbers[i];
    return true;
}

/// What can be said when all files are known.
Status SddsSource::finish() {
    if (!numberBy(pass) && !numberBy(stepNumber) && steps_.size() == files_.size()) {
        const bool all = std::all_of(files_.begin(), files_.end(),
                                     [](const File& file) { return file.number.has_value(); });
        for (std::size_t i = 0; all && i < steps_.size(); ++i) steps_[i].iteration = *files_[i].number;
    }
    const SddsColumns& first = files_.front().columns;
    if (first.massAssumed()) {
        progress_.note("no mass is given (--mass): the particles are taken for electrons");
    }
    if (first.rings()) {
        progress_.note(
            "the rows are rings, of a radius each: a ring becomes one particle, turned about the axis by the "
            "golden angle from the ring before it");
    }
    if (first.zFromTime()) {
        progress_.note(
            "z is found from the times at which the particles pass: z = -v_z (t - mean of t), in each step");
    }
    return success();
}

bool SddsSource::hasEverywhere(Column column) const {
    return std::all_of(pages_.begin(), pages_.end(), [&](const Page& page) {
        if (files_[page.file].columns.has(column)) return true;
        const bool empty = files_[page.file].pages->pages()[page.page].rows == 0;
        return column == Column::weight && (page.weight > 0.0 || empty);
    });
}

std::vector<SourceRecord> SddsSource::recordsEverywhere() const {
    auto records = files_.front().columns.records();
    std::erase_if(records, [&](const SourceRecord& record) {
        return !std::ranges::all_of(files_, [&](const File& file) {
            return std::ranges::count(file.columns.records(), record.name, &SourceRecord::name) > 0;
        });
    });
    return records;
}

/// In s, over all rows of the step where it is a number. The same for any order in which rows are asked for.
Result<double> SddsSource::meanTime(Page& page) {
    if (page.meanTime) return *page.meanTime;
    File& file = files_[page.file];
    const std::uint64_t rows = file.pages->pages()[page.page].rows;
    double mean = 0.0, counted = 0.0;
    for (std::uint64_t begin = 0; begin < rows; begin += rowsPerPass) {
        if (progress_.cancelled()) return wasCancelled("cancelled while a table was read");
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(rowsPerPass, rows - begin));
        MOTE_RETURN_IF_ERROR(
            file.pages->read(page.page, begin, count, {*file.columns.timeColumn()}, std::nullopt, rows_));
        for (const double value : rows_.columns[0]) {
            if (!std::isfinite(value)) continue;
            counted += 1.0;
            mean += (value - mean) / counted;
        }
    }
    page.meanTime = mean * file.columns.timeFactor();
    return *page.meanTime;
}

Status SddsSource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    Page& page = pages_[step];
    File& file = files_[page.file];
    const auto asked = [&](Column column) {
        return std::find(wanted.begin(), wanted.end(), column) != wanted.end();
    };
    double mean = 0.0;
    if (asked(Column::z) && file.columns.zFromTime()) {
        MOTE_ASSIGN_OR_RETURN(mean, meanTime(page));
    }
    const auto idColumn = asked(Column::id) ? file.columns.idColumn() : std::nullopt;
    auto columns = file.columns.needed(wanted);
    const std::size_t others = columns.size();
    for (const Column column : wanted) {
        if (isRecord(column)) columns.push_back(file.columns.recordColumn(recordName(column)));
    }
    MOTE_RETURN_IF_ERROR(file.pages->read(page.page, chunk.begin, chunk.size, columns, idColumn, rows_));
    file.columns.fill(wanted, rows_, mean, chunk);
    for (std::size_t next = others; const Column column : wanted) {
        if (isRecord(column)) chunk[column] = rows_.columns[next++];
    }
    if (asked(Column::weight)) {
        const bool own = file.columns.has(Column::weight);
        for (double& weight : chunk[Column::weight]) {
            weight = own ? std::abs(weight) : page.weight > 0.0 ? page.weight : 1.0;
        }
    }
    for (std::size_t i = 0; idColumn && i < chunk.size; ++i) chunk.id[i] = rows_.ids[i];
    return success();
}

template <bool hdf5>
Result<std::unique_ptr<ParticleSource>> openSdds(const AskedRun& run, Progress& progress) {
    return openSeries(std::make_unique<SddsSource>(hdf5 ? "elegant" : "sdds", run.mass, progress),
                      inOrder(run.files));
}

}  // namespace

extern const ParticleReader sddsReader;
constinit const ParticleReader sddsReader{
    "sdds", "its first line SDDS", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return looksLikeSdds(file.begin); }, openSdds<false>};
extern const ParticleReader elegantReader;
constinit const ParticleReader elegantReader{
    "elegant", "HDF5 with groups pageN/columns", ParticleReader::Kind::hdf5,
    [](const AskedFile& file) -> Result<bool> { return looksLikeSddsHdf5(*file.hdf5); }, openSdds<true>};

}  // namespace mote::prep
