// SPDX-License-Identifier: GPL-3.0-or-later
//
// A library for LD_PRELOAD in which chosen allocations fail: malloc and its like return null, so operator new
// throws. It acts in processes whose program is named MOTE_FAIL_PROGRAM, from main() on, and is told by the
// file MOTE_FAIL_ORDER, which both sides map: whoever writes to it hurts the process while it runs, and reads
// what became of it after its death. The functions that asked for the first allocation that failed are
// written to MOTE_FAIL_ORDER.trace, and those that ended the process after it to MOTE_FAIL_ORDER.abort.
//
// What takes pages from the kernel itself (mmap, oneTBB's own allocator) is not counted and does not fail.
// glibc's own functions, which are behind its malloc, serve what does not fail; nothing here allocates. Any
// thread.
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdio>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace {

using Main = int (*)(int, char**, char**);

/// As failing.py has it: the file's content, in the machine's byte order.
struct Order {
    std::atomic<std::uint64_t> process;  // that is hurt; 0: each that runs the program
    std::atomic<std::uint64_t> least;    // bytes; smaller allocations are not counted
    std::atomic<std::uint64_t> first;    // the number of the first that fails, from 1 on; 0: none does
    std::atomic<std::uint64_t> many;     // how many fail from that on
    std::atomic<std::uint64_t> count;    // how many there were
    std::atomic<std::uint64_t> failed;   // how many of them failed
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

std::atomic<Order*> order{nullptr};  // null: before main(), and where nothing is to fail
Main programMain = nullptr;
std::array<char, 4096> traceFile, abortFile;

/// Opened when it is needed: a program that counts its descriptors finds its own.
void writeTrace(const char* name) {
    std::array<void*, 64> frames;
    const int count = ::backtrace(frames.data(), static_cast<int>(frames.size()));
    const int file = ::open(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0) return;
    ::backtrace_symbols_fd(frames.data(), count, file);
    ::close(file);
}

bool fails(std::size_t size) {
    auto* const told = order.load(std::memory_order_acquire);
    if (told == nullptr || size < told->least) return false;
    const auto process = told->process.load();
    if (process != 0 && process != static_cast<std::uint64_t>(::getpid())) return false;
    const auto number = ++told->count;
    const auto first = told->first.load();
    if (first == 0 || number < first || number - first >= told->many) return false;
    if (++told->failed == 1) writeTrace(traceFile.data());
    errno = ENOMEM;
    return true;
}

Order* mapOrder() {
    const char* const program = ::getenv("MOTE_FAIL_PROGRAM");
    const char* const name = ::getenv("MOTE_FAIL_ORDER");
    if (program == nullptr || name == nullptr || ::strcmp(program, program_invocation_short_name) != 0)
        return nullptr;
    ::snprintf(traceFile.data(), traceFile.size(), "%s.trace", name);
    ::snprintf(abortFile.data(), abortFile.size(), "%s.abort", name);
    const int file = ::open(name, O_RDWR | O_CLOEXEC);
    if (file < 0) return nullptr;
    void* const mapped = ::mmap(nullptr, sizeof(Order), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    return mapped == MAP_FAILED ? nullptr : static_cast<Order*>(mapped);
}

/// What fails before main() ends any program, and harms nothing.
int countedMain(int argc, char** argv, char** environment) {
    std::array<void*, 1> frame;
    ::backtrace(frame.data(), 1);  // its first call loads a library, which allocates
    order.store(mapOrder(), std::memory_order_release);
    return programMain(argc, argv, environment);
}

}  // namespace

extern "C" {

int __libc_start_main(Main main, int argc, char** argv, void (*begin)(), void (*end)(), void (*unload)(),
                      void* stack) {
    using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
    programMain = main;
    const auto start = reinterpret_cast<Start>(::dlsym(RTLD_NEXT, "__libc_start_main"));
    return start(countedMain, argc, argv, begin, end, unload, stack);
}

/// As std::terminate() ends a process: it is still in the function that let an exception out.
void abort() noexcept {
    const auto* const told = order.load();
    if (told != nullptr && told->failed != 0) writeTrace(abortFile.data());
    reinterpret_cast<void (*)()>(::dlsym(RTLD_NEXT, "abort"))();
    ::_exit(127);
}

void* malloc(size_t size) noexcept {
    return fails(size) ? nullptr : __libc_malloc(size);
}

void* calloc(size_t count, size_t size) noexcept {
    return fails(count * size) ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* old, size_t size) noexcept {
    return size != 0 && fails(size) ? nullptr : __libc_realloc(old, size);
}

void* memalign(size_t alignment, size_t size) noexcept {
    return fails(size) ? nullptr : __libc_memalign(alignment, size);
}

void* aligned_alloc(size_t alignment, size_t size) noexcept {
    return memalign(alignment, size);
}

int posix_memalign(void** result, size_t alignment, size_t size) noexcept {
    if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return EINVAL;
    const int before = errno;
    void* const got = memalign(alignment, size);
    errno = before;
    if (got == nullptr) return ENOMEM;
    *result = got;
    return 0;
}
}
