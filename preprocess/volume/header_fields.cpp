// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/header_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include "preprocess/readers/text/number.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t mostDataFiles = VolumeShape::maxDimension;

Error tooMany(const std::string& where) {
    return corrupt(where, fmt::format("names more than {} data files", mostDataFiles));
}

/// "slice%03d.raw" and 7: "slice007.raw". "" if it has no place for a number.
std::string numbered(std::string_view pattern, std::uint64_t number) {
    const std::size_t percent = pattern.find('%');
    const std::size_t letter = pattern.find_first_not_of("0123456789", percent + 1);
    if (percent == std::string_view::npos || letter == std::string_view::npos) return "";
    if ((pattern[letter] != 'd' && pattern[letter] != 'u') || letter - percent > 3) return "";
    std::string_view width = pattern.substr(percent + 1, letter - percent - 1);
    const bool zeros = width.starts_with('0');
    const auto wide = static_cast<std::size_t>(parseId(width).value_or(0));
    std::string digits = std::to_string(number);
    if (digits.size() < wide) digits.insert(0, wide - digits.size(), zeros ? '0' : ' ');
    return fmt::format("{}{}{}", pattern.substr(0, percent), digits, pattern.substr(letter + 1));
}

Result<std::vector<std::string>> numberedNames(const std::array<std::string_view, 4>& words,
                                               const std::string& where) {
    const auto first = parseId(words[1]), last = parseId(words[2]);
    const bool down = words[3].starts_with('-');
    const auto step = parseId(words[3].substr(down ? 1 : 0));
    const bool named = first && last && step && *step > 0 && !numbered(words[0], 0).empty();
    if (!named || (down ? *first < *last : *last < *first)) {
        return corrupt(where,
                       fmt::format("\"{:.40} ...\" is no pattern of data files and their numbers", words[0]));
    }
    const std::uint64_t steps = (down ? *first - *last : *last - *first) / *step;
    if (steps >= mostDataFiles) return tooMany(where);
    std::vector<std::string> names;
    for (std::uint64_t i = 0; i <= steps; ++i) {
        names.push_back(numbered(words[0], down ? *first - i * *step : *first + i * *step));
    }
    return names;
}

Result<std::vector<std::string>> listedNames(std::string_view list, const std::string& where) {
    std::vector<std::string> names;
    while (!list.empty()) {
        const std::size_t end = std::min(list.find('\n'), list.size());
        const std::string_view name = trim(list.substr(0, end));
        if (!name.empty()) names.emplace_back(name);
        list.remove_prefix(std::min(end + 1, list.size()));
        if (names.size() > mostDataFiles) return tooMany(where);
    }
    if (names.empty()) return corrupt(where, "lists no data file");
    return names;
}

/// The path that `name` stands for, if the header may name it.
Result<fs::path> permitted(const fs::path& header, const std::string& name) {
    const std::string where = header.filename().string();
    std::error_code code;
    const fs::path folder =
        fs::weakly_canonical(header.parent_path().empty() ? "." : header.parent_path(), code);
    if (code) return notFound(where, "cannot be found: " + code.message());
    const fs::path file = fs::weakly_canonical(folder / name.c_str(), code);
    const auto [inFolder, inFile] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    if (!code && inFolder == folder.end()) return file;
    return Error{ErrorCode::permissionDenied, where,
                 "names a data file outside of its own folder; move the file there"};
}

Result<ByteStreamPtr> openNamed(const fs::path& header, const std::string& name) {
    MOTE_ASSIGN_OR_RETURN(const auto path, permitted(header, name));
    auto file = fileStream(path);
    if (file) return file;
    const Error& error = file.error();
    return Error{error.code, fmt::format("{}: data file {}", header.filename().string(), error.where),
                 error.message};
}

/// Files of the same number of bytes, of which one at a time is open.
class FileSeries : public ByteStream {
  public:
    FileSeries(fs::path header, std::vector<std::string> names, std::uint64_t bytes, Unwrap unwrap)
        : header_(std::move(header)),
          names_(std::move(names)),
          bytesOfFile_(bytes / names_.size()),
          unwrap_(std::move(unwrap)) {}

    std::string name() const override { return file_ ? file_->name() : header_.filename().string(); }
    bool sequential() const override { return file_->sequential(); }
    std::optional<std::uint64_t> size() const override { return mostBytes(); }
    std::uint64_t mostBytes() const override { return bytesOfFile_ * names_.size(); }

    Result<std::size_t> read(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size() && at_ < mostBytes()) {
            MOTE_RETURN_IF_ERROR(open(static_cast<std::size_t>(at_ / bytesOfFile_)));
            const auto left = std::min<std::uint64_t>(bytes.size() - done, bytesOfFile_ - at_ % bytesOfFile_);
            MOTE_ASSIGN_OR_RETURN(const auto got,
                                  file_->read(bytes.subspan(done, static_cast<std::size_t>(left))));
            if (got == 0) return wrongLength("less");
            done += got;
            at_ += got;
            if (at_ % bytesOfFile_ == 0) MOTE_RETURN_IF_ERROR(checkEnd());
        }
        return done;
    }

    Status seek(std::uint64_t offset) override {
        at_ = std::min(offset, mostBytes());
        if (at_ == mostBytes()) return success();
        MOTE_RETURN_IF_ERROR(open(static_cast<std::size_t>(at_ / bytesOfFile_)));
        return file_->seek(at_ % bytesOfFile_);
    }

    /// Holds each file's length against what it should have.
    Status check() {
        for (std::size_t i = 0; i < names_.size(); ++i) {
            MOTE_RETURN_IF_ERROR(open(i));
            const auto size = file_->size();
            if (size ? *size != bytesOfFile_ : file_->mostBytes() < bytesOfFile_) {
                return wrongLength(fmt::format("{}{}", size ? "" : "at most ", file_->mostBytes()));
            }
        }
        return seek(0);
    }

  private:
    Status checkEnd() {
        std::array<char, 1> one{};
        MOTE_ASSIGN_OR_RETURN(const auto got, file_->read(one));
        return got == 0 ? success() : Status(wrongLength("more"));
    }

    Error wrongLength(const std::string& held) const {
        return corrupt(name(), fmt::format("its share of the volume in {} is {} bytes, and it holds {}",
                                           header_.filename().string(), bytesOfFile_, held));
    }

    Status open(std::size_t index) {
        if (file_ && index == index_) return success();
        MOTE_ASSIGN_OR_RETURN(auto plain, openNamed(header_, names_[index]));
        MOTE_ASSIGN_OR_RETURN(auto file, unwrap_(std::move(plain), bytesOfFile_));
        file_ = std::move(file);
        index_ = index;
        return success();
    }

    fs::path header_;
    std::vector<std::string> names_;
    std::uint64_t bytesOfFile_;  ///< of what comes out of it
    Unwrap unwrap_;
    ByteStreamPtr file_;  ///< names_[index_]
    std::size_t index_ = 0;
    std::uint64_t at_ = 0;
};

constexpr std::size_t maxNumbers = 64;

/// Counts the bytes; of what is compressed, all must come out once.
Result<std::uint64_t> lengthOf(ByteStream& file) {
    if (const auto size = file.size()) return *size;
    std::vector<char> block(std::size_t{1} << 20);
    MOTE_RETURN_IF_ERROR(file.seek(0));
    for (std::uint64_t length = 0;;) {
        MOTE_ASSIGN_OR_RETURN(const auto got, file.read(block));
        length += got;
        if (got < block.size()) return length;
    }
}

}  // namespace

Result<std::vector<std::string>> dataFileNames(std::string_view field, std::string_view list,
                                               const std::string& where) {
    if (lower(field.substr(0, 4)) == "list") return listedNames(list, where);
    std::array<std::string_view, 4> words;
    const std::size_t count = splitFields(field, ' ', words);
    // A fifth word says how many axes a file has; its length says so, too.
    if ((count == 4 || count == 5) && words[0].find('%') != std::string_view::npos) {
        return numberedNames(words, where);
    }
    return std::vector<std::string>{std::string(field)};
}

Result<ByteStreamPtr> dataStream(DataFiles files, std::uint64_t bytes, const Unwrap& unwrap) {
    const std::size_t count = files.names.size();
    if (count < 2) {
        auto file = count == 0 ? partStream(std::move(files.headerFile), files.headerBytes)
                               : openNamed(files.header, files.names.front());
        return file ? unwrap(std::move(file).value(), bytes) : std::move(file);
    }
    if (bytes % count != 0) {
        return corrupt(files.header.filename().string(),
                       fmt::format("names {} data files, which cannot hold {} bytes evenly", count, bytes));
    }
    auto series =
        std::make_unique<FileSeries>(std::move(files.header), std::move(files.names), bytes, unwrap);
    MOTE_RETURN_IF_ERROR(series->check());
    return ByteStreamPtr(std::move(series));
}

Result<ByteStreamPtr> skipHeader(ByteStreamPtr file, std::optional<std::uint64_t> skip,
                                 std::uint64_t needed) {
    if (!skip) {
        MOTE_ASSIGN_OR_RETURN(const auto size, lengthOf(*file));
        skip = size - std::min(size, needed);
    }
    return partStream(std::move(file), *skip);
}

std::string HeaderFields::plain(std::string_view name) {
    std::string plain = lower(name);
    std::erase_if(plain, [](char c) { return c == ' ' || c == '\t'; });
    return plain;
}

Status HeaderFields::add(std::string_view name, std::string_view value) {
    const bool added = fields_.emplace(plain(name), trim(value)).second;
    return added ? success() : Status(corrupt(name, "stands there twice"));
}

std::string_view HeaderFields::text(std::string_view name) const {
    const auto found = fields_.find(plain(name));
    return found == fields_.end() ? std::string_view() : found->second;
}

Result<std::vector<double>> HeaderFields::numbers(std::string_view name) const {
    std::array<std::string_view, maxNumbers> words;
    const std::size_t count = splitFields(text(name), ' ', words);
    if (count > maxNumbers) return corrupt(name, fmt::format("has more than {} numbers", maxNumbers));
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = parseNumber(words[i]);
        if (!number) return corrupt(name, fmt::format("\"{:.20}\" is no number", words[i]));
        numbers[i] = *number;
    }
    return numbers;
}

Result<std::vector<double>> HeaderFields::numbers(std::string_view name, std::size_t count) const {
    auto all = numbers(name);
    if (!all) return all.error();
    if (all->size() != count) {
        return corrupt(name, fmt::format("has {} numbers in place of {}", all->size(), count));
    }
    for (const double number : *all) {
        if (!std::isfinite(number)) return corrupt(name, fmt::format("says {}", number));
    }
    return all;
}

Result<std::vector<std::uint64_t>> HeaderFields::wholeNumbers(std::string_view name) const {
    MOTE_ASSIGN_OR_RETURN(const auto all, numbers(name));
    std::vector<std::uint64_t> whole;
    for (const double number : all) {
        if (!(number >= 0.0 && number < 0x1p53 && number == std::floor(number))) {
            return corrupt(name, fmt::format("says {}, which is no count", number));
        }
        whole.push_back(static_cast<std::uint64_t>(number));
    }
    return whole;
}

Result<std::uint64_t> HeaderFields::wholeNumber(std::string_view name, std::uint64_t otherwise) const {
    MOTE_ASSIGN_OR_RETURN(const auto all, wholeNumbers(name));
    if (all.size() > 1) return corrupt(name, fmt::format("has {} numbers in place of one", all.size()));
    return all.empty() ? otherwise : all.front();
}

Result<ScalarType> HeaderFields::type(std::string_view name, std::span<const ScalarTypeName> names) const {
    const std::string_view said = text(name);
    const auto found = std::find_if(names.begin(), names.end(), [&](const ScalarTypeName& one) {
        return lower(one.name) == lower(said);
    });
    if (found != names.end()) return found->type;
    return unsupported(name, fmt::format("\"{:.40}\" is no integer of 8 to 64 bits, float or double", said));
}

bool HeaderFields::flag(std::string_view name, bool otherwise) const {
    const std::string_view said = text(name);
    if (said.empty()) return otherwise;
    return said.front() == 'T' || said.front() == 't' || said.front() == '1' || said.front() == 'Y' ||
           said.front() == 'y';
}

}  // namespace mote::prep
