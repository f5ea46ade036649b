// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/arrays/array_file.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <optional>

#include "protocol/base/json.h"
#include "protocol/base/system_error.h"
#include "protocol/mote.pb.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/files/dataset_file.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t digestLimit = std::size_t{1} << 26;  // bytes; enough for arrays of some 2 TB

FileLayout layoutOf(const ArrayFileContent& content) {
    FileLayout layout{content.groups, {}, content.attributes};
    for (const auto& array : content.arrays) {
        MOTE_CHECK(array.bytes.size() == bytesOf(array.layout));
        layout.arrays.push_back(array.layout);
    }
    return layout;
}

bool matches(const std::vector<std::uint64_t>& shape, const std::vector<std::uint64_t>& expected) {
    return std::equal(
        shape.begin(), shape.end(), expected.begin(), expected.end(),
        [](std::uint64_t is, std::uint64_t should) { return should == ArrayFile::any || is == should; });
}

std::string describe(const std::vector<std::uint64_t>& shape) {
    std::string text;
    for (const auto extent : shape) {
        text += text.empty() ? "" : ", ";
        text += extent == ArrayFile::any ? "any" : std::to_string(extent);
    }
    return "[" + text + "]";
}

/// The digest of a file of arrays whose name ends with `suffix`.
Result<proto::Digest> findDigest(const PathBeneath& directory, const proto::Manifest& manifest,
                                 const std::string& name, std::string_view suffix) {
    const auto* digest = findFile(manifest, name + ".digest");
    if (digest && findFile(manifest, name + std::string(suffix)))
        return readDigest(directory / digest->name(), *digest);
    return Error{ErrorCode::corrupt, (directory / manifestName).string(),
                 fmt::format("names no {0}{1} with {0}.digest", name, suffix)};
}

}  // namespace

Status writeArrayFile(const fs::path& directory, const std::string& name, const ArrayFileContent& content) {
    MOTE_ASSIGN_OR_RETURN(const auto writer, ArrayFileWriter::create(directory, name, layoutOf(content)));
    for (std::size_t i = 0; i < content.arrays.size(); ++i) {
        MOTE_RETURN_IF_ERROR(writer.write(i, 0, content.arrays[i].bytes));
    }
    const auto finished = writer.finish();
    return finished.ok() ? success() : Status(finished.error());
}

Result<proto::Digest> readDigest(const PathBeneath& path, const proto::FileEntry& entry) {
    MOTE_ASSIGN_OR_RETURN(const auto text, readWhole(path, digestLimit));
    if (text.size() != entry.size() || hash128(std::as_bytes(std::span(text))) != entry.xxh3_128()) {
        return Error{ErrorCode::corrupt, path.string(),
                     "differs from its hash in the manifest; the dataset is damaged: copy or make it again"};
    }
    proto::Digest digest;
    const auto parsed = parseJson(text, digest, path.string());
    if (parsed.ok()) return digest;
    return Error{ErrorCode::corrupt, parsed.error().where, parsed.error().message};
}

Result<ArrayFile> ArrayFile::open(const PathBeneath& directory, const proto::Manifest& manifest,
                                  const std::string& name) {
    MOTE_ASSIGN_OR_RETURN(const auto digest, findDigest(directory, manifest, name, ".h5"));
    const auto& entry = *findFile(manifest, name + ".h5");
    return of(MappedFile::open(directory / entry.name(), entry.size()), digest);
}

Result<ArrayFile> ArrayFile::openPacked(const PathBeneath& directory, const proto::Manifest& manifest,
                                        const std::string& name, std::uint64_t most) {
    MOTE_ASSIGN_OR_RETURN(const auto digest, findDigest(directory, manifest, name, ".h5.zst"));
    return of(MappedFile::unpack(directory / (name + ".h5.zst"), most), digest);
}

Result<ArrayFile> ArrayFile::of(Result<MappedFile> mapped, const proto::Digest& digest) {
    if (!mapped.ok()) return mapped.error();
    ArrayFile file(*std::move(mapped));
    for (const auto& described : digest.arrays()) {
        MOTE_ASSIGN_OR_RETURN(auto array, VerifiedArray::make(*file.file_, described, nullptr));
        file.arrays_.push_back({described.name(), std::move(array)});
    }
    return file;
}

const VerifiedArray* ArrayFile::find(const std::string& name) const {
    const auto found =
        std::find_if(arrays_.begin(), arrays_.end(), [&](const Named& named) { return named.name == name; });
    return found == arrays_.end() ? nullptr : &found->array;
}

Result<std::span<const std::byte>> ArrayFile::verified(const std::string& name, const char* type,
                                                       const std::vector<std::uint64_t>& shape) const {
    const auto corrupt = [&](std::string message) {
        return Error{ErrorCode::corrupt, where(name), std::move(message)};
    };
    const auto* const found = find(name);
    if (!found) return corrupt("is missing in the digest");
    const auto& array = *found;
    if (array.type() != type) return corrupt("has the wrong type");
    if (!matches(array.shape(), shape)) {
        return corrupt(fmt::format("has the shape {}, not {}", describe(array.shape()), describe(shape)));
    }
    try {
        return array.get<std::byte>(0, array.bytes());
    } catch (const StorageError& error) {
        return error.error();
    }
}

std::vector<Error> ArrayFile::verify(const std::function<bool()>& cancelled) const {
    std::vector<Error> errors;
    for (const auto& [name, array] : arrays_) {
        for (std::size_t block = 0; block < array.blockCount(); ++block) {
            if (cancelled && cancelled()) return {{ErrorCode::cancelled, file_->path(), "cancelled"}};
            if (auto error = array.checkBlock(block)) errors.push_back(*std::move(error));
        }
    }
    return errors;
}

Status ArrayFile::check() const {
    if (const auto damage = file_->damage()) return *damage;
    return success();
}

Result<ArrayFileWriter> ArrayFileWriter::create(const fs::path& directory, const std::string& name,
                                                FileLayout layout) {
    MOTE_ASSIGN_OR_RETURN(auto places, layOutFile(directory / (name + ".h5"), layout));
    return open(directory, name, std::move(layout), std::move(places));
}

Result<ArrayFileWriter> ArrayFileWriter::open(const fs::path& directory, const std::string& name,
                                              FileLayout layout, std::vector<ArrayPlace> places) {
    auto path = directory / (name + ".h5");
    MOTE_CHECK(places.size() == layout.arrays.size());
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return ArrayFileWriter(std::move(path), std::move(layout), std::move(places), std::move(file));
}

Status ArrayFileWriter::write(std::size_t array, std::uint64_t at, std::span<const std::byte> bytes) const {
    const auto& place = places_[array];
    MOTE_CHECK(at <= place.bytes && bytes.size() <= place.bytes - at);
    if (together_) bringPages(file_.get(), place.offset + at, bytes.size());
    return writeAt(file_.get(), place.offset + at, bytes, path_, cache_);
}

Status ArrayFileWriter::read(std::size_t array, std::uint64_t at, std::span<std::byte> bytes) const {
    const auto& place = places_[array];
    MOTE_CHECK(at <= place.bytes && bytes.size() <= place.bytes - at);
    return readAt(file_.get(), place.offset + at, bytes, path_, cache_);
}

HashPass::File ArrayFileWriter::forHashes() const {
    return {file_.get(), path_, places_, std::vector(places_.size(), cache_)};
}

void ArrayFileWriter::hashAhead(std::function<bool()> cancelled, HashPass::Held held) {
    auto file = forHashes();
    file.held = std::move(held);
    pass_ = std::make_unique<HashPass>(std::move(file), std::move(cancelled));
    pass_->begin();
}

void ArrayFileWriter::complete(std::size_t array) const {
    if (pass_) pass_->complete(array);
}

Result<FileHash> ArrayFileWriter::finish(const std::function<bool()>& cancelled) const {
    std::optional<HashPass> own;
    if (!pass_) own.emplace(forHashes(), cancelled);
    auto& pass = pass_ ? *pass_ : *own;
    MOTE_ASSIGN_OR_RETURN(auto whole, pass.finish());
    proto::Digest digest;
    for (std::size_t i = 0; i < places_.size(); ++i) {
        auto& array = *digest.add_arrays();
        array.set_name(layout_.arrays[i].name);
        array.set_type(layout_.arrays[i].type);
        for (const auto extent : layout_.arrays[i].shape) array.add_shape(extent);
        array.set_offset(places_[i].offset);
        array.mutable_blocks()->Assign(pass.blocks(i).begin(), pass.blocks(i).end());
    }
    MOTE_RETURN_IF_ERROR(writeNewFile(fs::path(path_).replace_extension(".digest"), toJson(digest)));
    return whole;
}

}  // namespace mote::storage
