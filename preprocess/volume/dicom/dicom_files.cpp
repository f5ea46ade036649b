// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_files.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <system_error>

#include "preprocess/volume/archive_stream.h"
#include "preprocess/volume/dicom/dicom_header.h"
#include "preprocess/volume/volume_formats.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t mostFiles = 1u << 20, mostEntries = 1u << 16;
constexpr int deepestFolder = 8;

/// What a file of other kinds says when it is opened is not asked.
bool isDicom(const DicomFile& file) {
    auto stream = file.open();
    if (!stream) return false;
    const auto head = readHead(**stream, DicomHeader::headBytes);
    return head && DicomHeader::begins(*head);
}

bool isHidden(const fs::path& path) {
    return path.filename().string().starts_with('.');
}

Error tooMany(const fs::path& folder) {
    return {ErrorCode::resourceExhausted, folder.filename().string(),
            fmt::format("holds more than {} files", mostFiles)};
}

Error unreadable(const fs::path& folder, std::error_code code) {
    const bool denied = code == std::errc::permission_denied;
    return {denied ? ErrorCode::permissionDenied : ErrorCode::internal, folder.filename().string(),
            "cannot be read: " + code.message()};
}

void sortNaturally(std::vector<fs::path>& files) {
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return naturallyLess(a.string(), b.string()); });
}

/// Names of a folder's files, and of those below it.
Result<std::vector<fs::path>> filesBelow(const fs::path& folder, const Progress& progress) {
    std::vector<fs::path> files;
    std::error_code code;
    const auto options = fs::directory_options::skip_permission_denied;
    fs::recursive_directory_iterator entry(folder, options, code);
    for (const fs::recursive_directory_iterator end; !code && entry != end; entry.increment(code)) {
        if (isHidden(entry->path()) || entry.depth() >= deepestFolder) {
            entry.disable_recursion_pending();
            if (isHidden(entry->path())) continue;
        }
        std::error_code ignored;
        if (entry->is_regular_file(ignored)) files.push_back(entry->path());
        if (files.size() > mostFiles) return tooMany(folder);
        if (progress.cancelled()) return wasCancelled("cancelled while DICOM files were looked for");
    }
    if (code) return unreadable(folder, code);
    sortNaturally(files);
    return files;
}

/// Files of a folder whose names are like the last part of `input`, "IM*".
Result<std::vector<fs::path>> filesLike(const fs::path& input) {
    const fs::path folder = input.parent_path().empty() ? fs::path(".") : input.parent_path();
    const std::string pattern = input.filename().string();
    std::vector<fs::path> files;
    std::error_code code, ignored;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
        const std::string name = entry->path().filename().string();
        if (fnmatch(pattern.c_str(), name.c_str(), FNM_PERIOD) != 0) continue;
        if (entry->is_regular_file(ignored)) files.push_back(entry->path());
        if (files.size() > mostFiles) return tooMany(input);
    }
    if (code && code != std::errc::no_such_file_or_directory) return unreadable(folder, code);
    sortNaturally(files);
    return files;
}

/// Folders of an archive often are patients' names.
Error withoutFolders(Error error) {
    const auto entry = error.where.find(": "), last = error.where.rfind('/');
    if (entry != std::string::npos && last != std::string::npos && last > entry) {
        error.where.erase(entry + 2, last - entry - 1);
    }
    return error;
}

/// Finds all that may be one: those of a folder, the entries of an archive, the file.
Result<std::vector<DicomFile>> candidates(const fs::path& input, const Progress& progress) {
    std::vector<DicomFile> files;
    std::error_code code;
    if (namesPictures(input)) {
        const bool whole = fs::is_directory(input, code);
        MOTE_ASSIGN_OR_RETURN(const auto paths, whole ? filesBelow(input, progress) : filesLike(input));
        for (const auto& path : paths) files.push_back({path});
        return files;
    }
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(input));
    std::string head(4, '\0');
    MOTE_ASSIGN_OR_RETURN(const auto got, source->read(head));
    if (source->compressed() || !looksLikeZip(std::string_view(head).substr(0, got))) {
        files.push_back({input});
        return files;
    }
    auto directory = readZipDirectory(*source, mostEntries);
    if (!directory) return withoutFolders(directory.error());
    auto entries = std::move(directory).value();
    std::sort(entries.begin(), entries.end(),
              [](const ZipEntry& a, const ZipEntry& b) { return naturallyLess(a.name, b.name); });
    for (auto& entry : entries) files.push_back({input, std::move(entry)});
    return files;
}

}  // namespace

std::string DicomFile::name() const {
    return entry ? path.filename().string() + ": " + fs::path(entry->name).filename().string()
                 : path.filename().string();
}

Result<ByteStreamPtr> DicomFile::open() const {
    if (!entry) return fileStream(path);
    const ArrayBytes::Part part{path,         name(),          entry->offset,  entry->storedBytes,
                                entry->bytes, entry->deflated, entry->checksum};
    return archiveStream(part);
}

Result<std::vector<DicomFile>> dicomFiles(const fs::path& input, const Progress& progress,
                                          std::optional<std::size_t> most) {
    MOTE_ASSIGN_OR_RETURN(auto all, candidates(input, progress));
    std::vector<DicomFile> files;
    for (auto& file : all) {
        if (progress.cancelled()) return wasCancelled("cancelled while DICOM files were looked for");
        if (most && files.size() == *most) break;
        if (isDicom(file)) files.push_back(std::move(file));
    }
    return files;
}

Result<bool> holdsDicom(const fs::path& input, const Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto files, dicomFiles(input, progress, 1));
    return !files.empty();
}

}  // namespace mote::prep
