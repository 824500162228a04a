#include "afferent/io/files/hdf5_process.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "afferent/io/files/column_text.hpp"
#include "afferent/io/files/hdf5_format.hpp"

extern char** environ;

namespace afferent {
namespace {

namespace fs = std::filesystem;

std::string because(int code) { return std::generic_category().message(code); }

Error error_of(const fs::path& file, const std::string& text) {
    return {Error::Kind::malformed, file.string() + ": " + text};
}

struct Ended {
    int status;
    std::vector<std::byte> said;  // on its standard output
};

// Starts the program with this standard input.
Result<ReadingProcess> start_program(const fs::path& program, std::vector<std::string> arguments,
                                     std::FILE* input) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const auto failed = [&](int code) {
        return Error{Error::Kind::unreachable,
                     code == ENOENT ? "HDF5 files are read and written by a program of its own, " +
                                          program.filename().string() +
                                          ", which is neither beside this one nor in PATH. Build it: "
                                          "scripts/build.sh release " +
                                          program.filename().string()
                                    : program.string() + " cannot be started: " + because(code)};
    };

    std::array<int, 2> pipe{};
    if (::pipe(pipe.data()) != 0) return failed(errno);
    InputFile output(::fdopen(pipe[0], "rb"));
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, fileno(input), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, pipe[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
    pid_t process = 0;
    const int refused = posix_spawnp(&process, program.c_str(), &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    ::close(pipe[1]);
    if (refused != 0) return failed(refused);

    return ReadingProcess(process, std::move(output));
}

// What the program says, to its end.
Ended end_of(ReadingProcess& process, std::vector<std::byte> said = {}) {
    std::array<std::byte, 1 << 16> bytes;
    while (const std::size_t size = process.read(bytes))
        said.insert(said.end(), bytes.begin(), bytes.begin() + size);
    return {process.wait(), std::move(said)};
}

// Runs the program with this standard input, to its end.
Result<Ended> run(const fs::path& program, std::vector<std::string> arguments, std::FILE* input) {
    AFFERENT_TRY(process, start_program(program, std::move(arguments), input));
    return end_of(process);
}

std::string text(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Why the program has failed.
Error why(const fs::path& file, const Ended& ended, Hdf5Limits limits) {
    if (WIFEXITED(ended.status)) return error_of(file, text(ended.said));
    const int signal = WTERMSIG(ended.status);
    if (signal == SIGXCPU || signal == SIGKILL)
        return error_of(file, "the library for HDF5 has not come to an end with it in " +
                                  std::to_string(limits.processor_time.count()) +
                                  " s of processor time. The file is damaged, or was made to do that");
    return error_of(file, std::string("the library for HDF5 has crashed on it (") + ::strsignal(signal) +
                              "). The file is damaged, or was made to do that");
}

// A file of this size takes less time and memory than this, unless it is a bomb.
Hdf5Limits limits_for(std::uintmax_t bytes) {
    constexpr std::uintmax_t bytes_per_s = 2'000'000;
    return {.processor_time = std::chrono::seconds(3 + static_cast<std::int64_t>(bytes / bytes_per_s)),
            .memory_mb = 1024 + 16 * (bytes >> 20U)};
}

Hdf5Limits limits_of(const fs::path& file) {
    std::error_code failure;
    const std::uintmax_t size = fs::file_size(file, failure);
    return limits_for(failure ? 0 : size);
}

Result<ScanSet> scans_of(const fs::path& file, const std::string& what, Ended ended) {
    // A program that fails has said why, unless it had begun with the numbers.
    constexpr std::size_t longest_reason = 10'000;
    if (ended.status != 0) {
        if (ended.said.size() > longest_reason) return error_of(file, what + " cannot be read to its end");
        return why(file, ended, limits_of(file));
    }
    auto set = ScanSet::of(std::move(ended.said));
    if (!set) return error_of(file, set.error().text);
    return set;
}

std::string since_1970_ms(std::chrono::system_clock::time_point time) {
    return std::to_string(
        std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count());
}

}  // namespace

Result<EventSet> Hdf5Process::read(const fs::path& file) const {
    std::uintmax_t size = 0;
    for (const fs::path& each : {file, sonata_nodes(file)}) {
        std::error_code failure;
        const std::uintmax_t bytes = fs::file_size(each, failure);
        if (!failure) size += bytes;
    }
    return read(file, limits_for(size));
}

Result<EventSet> Hdf5Process::read(const fs::path& file, Hdf5Limits limits) const {
    AFFERENT_TRY(open_input(file));
    if (!fs::is_regular_file(file)) return error_of(file, "is not a file of events");
    AFFERENT_TRY(nothing, open_input("/dev/null"));
    AFFERENT_TRY(ended, run(program_,
                            {program_.filename().string(), "read", file.string(),
                             std::to_string(limits.processor_time.count()), std::to_string(limits.memory_mb)},
                            nothing.get()));
    if (ended.status != 0) return why(file, ended, limits);
    auto set = event_set(ended.said);
    if (!set) return error_of(file, set.error().text);
    return set;
}

ReadingProcess::ReadingProcess(ReadingProcess&& other) noexcept
    : process_(std::exchange(other.process_, 0)), output_(std::move(other.output_)) {}

ReadingProcess::~ReadingProcess() {
    if (process_ == 0) return;
    ::kill(process_, SIGKILL);
    wait();
}

std::size_t ReadingProcess::read(std::span<std::byte> bytes) {
    return std::fread(bytes.data(), 1, bytes.size(), output_.get());
}

int ReadingProcess::wait() {
    int status = 0;
    while (process_ != 0 && ::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return status;
}

Result<std::size_t> ColumnTextInput::read(std::span<char> buffer) {
    const std::size_t size = process_.read(std::as_writable_bytes(buffer));
    const std::string_view text(buffer.data(), size);
    const std::size_t reason = text.find(why_no_more);
    if (reason != std::string_view::npos) {
        const std::string begun(text.substr(reason + 1));
        const auto rest = end_of(process_);
        return error_of(file_, begun + afferent::text(rest.said));
    }
    lines_ += static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
    if (size != 0) return size;
    const Ended ended{process_.wait(), {}};
    if (WIFEXITED(ended.status) && ended.status == 0) return size;
    return WIFEXITED(ended.status) ? error_of(file_, "the table cannot be read to its end")
                                   : why(file_, ended, limits_);
}

Result<ReadingProcess> Hdf5Process::start(const fs::path& file, std::vector<std::string> before,
                                          const std::vector<std::string>& after,
                                          const std::string& what) const {
    AFFERENT_TRY(open_input(file));
    if (!fs::is_regular_file(file)) return error_of(file, "is not a file of " + what);
    AFFERENT_TRY(nothing, open_input("/dev/null"));
    const Hdf5Limits limits = limits_of(file);
    before.insert(before.begin(), program_.filename().string());
    before.insert(before.end(), {file.string(), std::to_string(limits.processor_time.count()),
                                 std::to_string(limits.memory_mb)});
    before.insert(before.end(), after.begin(), after.end());
    return start_program(program_, std::move(before), nothing.get());
}

Result<ScanSet> Hdf5Process::read_scans(const fs::path& file, const std::string& dataset) const {
    AFFERENT_TRY(process, start(file, {"scans"}, {dataset}, dataset));
    return scans_of(file, dataset, end_of(process));
}

Result<Hdf5Process::Recorded> Hdf5Process::read_table(const fs::path& file,
                                                      const TableOptions& options) const {
    std::vector<std::string> arguments{options.rate_hz ? "1" : "0", options.time_column};
    arguments.insert(arguments.end(), options.columns.begin(), options.columns.end());
    AFFERENT_TRY(process, start(file, {"table"}, arguments, "the table"));
    std::vector<std::byte> begun(sizeof(ColumnTextHead));
    begun.resize(process.read(begun));
    ColumnTextHead head;
    if (begun.size() == sizeof head) std::memcpy(&head, begun.data(), sizeof head);
    if (begun.size() == sizeof head && head.format == ColumnTextHead::this_format)
        return Recorded(ColumnTextInput(file, std::move(process), limits_of(file), head.rows));
    AFFERENT_TRY(scans, scans_of(file, "the table", end_of(process, std::move(begun))));
    return Recorded(std::move(scans));
}

Result<void> Hdf5Process::write(const fs::path& file, const EventSet& set,
                                std::chrono::system_clock::time_point began,
                                std::chrono::system_clock::time_point now) const {
    const std::vector<std::byte> bytes = to_bytes(set);
    const InputFile input(std::tmpfile());
    if (!input || std::fwrite(bytes.data(), 1, bytes.size(), input.get()) != bytes.size() ||
        std::fflush(input.get()) != 0)
        return error_of(file, "no room for a temporary file: " + because(errno));
    std::rewind(input.get());
    const Hdf5Limits limits = limits_for(bytes.size());
    AFFERENT_TRY(ended, run(program_,
                            {program_.filename().string(), "write", file.string(),
                             std::to_string(limits.processor_time.count()), std::to_string(limits.memory_mb),
                             since_1970_ms(began), since_1970_ms(now)},
                            input.get()));
    if (ended.status != 0) return why(file, ended, limits);
    return success();
}

}  // namespace afferent
