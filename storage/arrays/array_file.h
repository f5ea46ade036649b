// SPDX-License-Identifier: GPL-3.0-or-later
//
// A dataset's file of a few arrays that are written at once and read whole: NAME.h5 and NAME.digest, laid out
// as docs/FORMAT.md says. (One that is written in parts is an ArrayFileWriter's; steps of particles are a
// StepFile's and a MappedStep's.) ArrayFile is move-only and may be read from any thread; writing has one
// thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/arrays/hash_pass.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/blocks/mapped_file.h"
#include "storage/blocks/verified_array.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"
#include "storage/files/path_beneath.h"
#include "storage/hash.h"

namespace mote::storage {

template <class T>
inline constexpr const char* arrayType = nullptr;
template <>
inline constexpr const char* arrayType<std::uint8_t> = "u8";
template <>
inline constexpr const char* arrayType<std::uint16_t> = "u16";
template <>
inline constexpr const char* arrayType<std::uint32_t> = "u32";
template <>
inline constexpr const char* arrayType<std::uint64_t> = "u64";
template <>
inline constexpr const char* arrayType<float> = "f32";
template <>
inline constexpr const char* arrayType<double> = "f64";

/// An array as its owner has it; the bytes must outlive the writing.
struct ArrayContent {
    ArrayLayout layout;
    std::span<const std::byte> bytes;
};

/// `values` are as many as the shape says.
template <class T>
ArrayContent arrayContent(std::string name, std::vector<std::uint64_t> shape, std::span<const T> values) {
    return {{std::move(name), arrayType<T>, std::move(shape)}, std::as_bytes(values)};
}

struct ArrayFileContent {
    std::vector<std::string> groups;
    std::vector<ArrayContent> arrays;
    std::vector<ArrayAttribute> attributes;
};

/// Writes `directory`/NAME.h5 and NAME.digest, both new. The same content gives the same bytes. Errors:
/// resourceExhausted (disk full), permissionDenied, alreadyExists, internal.
Status writeArrayFile(const std::filesystem::path& directory, const std::string& name,
                      const ArrayFileContent& content);

/// A digest, held to the manifest's hash of its file. Errors: notFound, corrupt.
Result<proto::Digest> readDigest(const PathBeneath& path, const proto::FileEntry& entry);

class ArrayFile {
  public:
    /// NAME.h5 and NAME.digest of a dataset. Nothing but the digest is read yet. Errors: notFound, corrupt.
    static Result<ArrayFile> open(const PathBeneath& directory, const proto::Manifest& manifest,
                                  const std::string& name);

    /// The same of NAME.h5.zst (packed_file.h), which holds `most` bytes at most. All is unpacked into
    /// memory.
    static Result<ArrayFile> openPacked(const PathBeneath& directory, const proto::Manifest& manifest,
                                        const std::string& name, std::uint64_t most);

    bool has(const std::string& name) const { return find(name) != nullptr; }

    /// A whole array, every block verified. An extent of the shape that is `any` may be anything. Errors:
    /// corrupt (missing, another type or shape, a block that differs; with file, array and offset).
    template <class T>
    Result<std::span<const T>> get(const std::string& name, const std::vector<std::uint64_t>& shape) const {
        MOTE_ASSIGN_OR_RETURN(const auto bytes, verified(name, arrayType<T>, shape));
        return std::span<const T>(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T));
    }
    static constexpr std::uint64_t any = ~std::uint64_t{0};

    /// Where an array lies, for errors: "DIR/NAME.h5:/points/rank".
    std::string where(const std::string& name) const { return file_->path() + ":" + name; }

    /// Every block of every array. `cancelled` is asked between them. Errors as they are found; one of
    /// `cancelled` alone if it said so.
    std::vector<Error> verify(const std::function<bool()>& cancelled) const;

    /// What became of the file while it was read (mapped_file.h).
    Status check() const;

  private:
    struct Named {
        std::string name;
        VerifiedArray array;
    };
    static Result<ArrayFile> of(Result<MappedFile> mapped, const proto::Digest& digest);
    explicit ArrayFile(MappedFile file) : file_(std::make_unique<MappedFile>(std::move(file))) {}
    const VerifiedArray* find(const std::string& name) const;  ///< null if there is none
    Result<std::span<const std::byte>> verified(const std::string& name, const char* type,
                                                const std::vector<std::uint64_t>& shape) const;

    std::unique_ptr<MappedFile> file_;  ///< the arrays hold its address
    std::vector<Named> arrays_;
};

/// A dataset's file of arrays while it is written in parts: NAME.h5 and NAME.digest, laid
/// out as docs/FORMAT.md says. Move-only; write() and read() may be called from any thread, and by processes
/// that opened what another one made.
class ArrayFileWriter {
  public:
    /// Makes `directory`/NAME.h5, which must be new. The same layout and bytes give the same file. Errors: as
    /// layOutFile.
    static Result<ArrayFileWriter> create(const std::filesystem::path& directory, const std::string& name,
                                          FileLayout layout);

    /// The file that another process made of the same layout. Errors: notFound, permissionDenied.
    static Result<ArrayFileWriter> open(const std::filesystem::path& directory, const std::string& name,
                                        FileLayout layout, std::vector<ArrayPlace> places);

    const std::vector<ArrayPlace>& places() const { return places_; }

    /// Bytes of an array, by its index in the layout, from its byte `at` on. Errors: resourceExhausted (disk
    /// full), internal.
    Status write(std::size_t array, std::uint64_t at, std::span<const std::byte> bytes) const;
    /// The same of what was written, by whomever. Errors: internal.
    Status read(std::size_t array, std::uint64_t at, std::span<std::byte> bytes) const;

    /// Nothing that is written or read from now on is kept in the system's cache.
    void passCache() { cache_ = PageCache::passed; }
    /// Several threads or processes write at once (bringPages()).
    void writeTogether() { together_ = true; }

    /// From now on arrays are read back for finish(), by a thread of their own, as complete() is called of
    /// them; but for what `held` has of them. `cancelled` is asked from that thread, too.
    void hashAhead(std::function<bool()> cancelled, HashPass::Held held = {});
    /// All of an array is written, by its index in the layout. One thread at a time.
    void complete(std::size_t array) const;

    /// Reads back what is in the file, once, writes the digest of it, and returns the hash of the whole. Uses
    /// all threads of the calling arena. Called once. Errors: resourceExhausted, internal, cancelled.
    Result<FileHash> finish(const std::function<bool()>& cancelled = {}) const;

  private:
    ArrayFileWriter(std::filesystem::path path, FileLayout layout, std::vector<ArrayPlace> places,
                    FileDescriptor file)
        : path_(std::move(path)),
          layout_(std::move(layout)),
          places_(std::move(places)),
          file_(std::move(file)) {}
    HashPass::File forHashes() const;

    std::filesystem::path path_;
    FileLayout layout_;
    std::vector<ArrayPlace> places_;
    FileDescriptor file_;
    PageCache cache_ = PageCache::kept;
    bool together_ = false;
    std::unique_ptr<HashPass> pass_;  ///< once hashAhead() was called; ends before the file is closed
};

}  // namespace mote::storage
