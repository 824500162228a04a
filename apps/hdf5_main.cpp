// The program afferent-hdf5: reads a file of events, of scans or of a table in HDF5, or of a table in NumPy's
// or MATLAB's formats, to standard output, or writes one of events from standard input. A program of its own
// with limits on time and memory, because the library for HDF5 does not withstand a hostile file. `afferent`
// starts it; what it says on standard output is the events or scans, or why there are none.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "afferent/io/files/hdf5_columns.hpp"
#include "afferent/io/files/hdf5_files.hpp"
#include "afferent/io/files/mat_file.hpp"
#include "afferent/io/files/npz_file.hpp"
#include "afferent/io/files/scan_file.hpp"

namespace afferent {
namespace {

// No core dump of somebody else's file, and no file written where one is read.
void limit(rlim_t processor_s, rlim_t memory_mb, bool writes) {
    const auto set = [](auto resource, rlim_t most, rlim_t grace = 0) {
        const rlimit both{most, most + grace};
        ::setrlimit(resource, &both);
    };
    set(RLIMIT_CPU, processor_s, 1);                                 // SIGXCPU, which says why
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they take terabytes of addresses
    set(RLIMIT_AS, memory_mb << 20U);
#else
    (void)memory_mb;
#endif
    set(RLIMIT_CORE, 0);
    if (!writes) set(RLIMIT_FSIZE, 0);
}

void say(std::span<const std::byte> bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() || std::fflush(stdout) != 0)
        std::_Exit(EXIT_FAILURE);
}

int refuse(const std::string& why) {
    say(std::as_bytes(std::span(why)));
    return EXIT_FAILURE;
}

std::vector<std::byte> standard_input() {
    std::vector<std::byte> bytes;
    std::vector<std::byte> piece(1 << 20);
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), stdin))
        bytes.insert(bytes.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(size));
    return bytes;
}

std::chrono::system_clock::time_point since_1970(const char* ms) {
    return std::chrono::system_clock::time_point(std::chrono::milliseconds(std::atoll(ms)));
}

int read(const std::string& file, Hdf5Format format) {
    const auto set = format == Hdf5Format::sonata ? read_sonata(file) : read_nwb(file);
    if (!set) return refuse(set.error().text);
    say(to_bytes(set.value()));
    return EXIT_SUCCESS;
}

int scans(const std::string& file, const std::string& dataset) {
    const auto read = read_scans(file, dataset, say);
    return read ? EXIT_SUCCESS : refuse(read.error().text);
}

// A table: RATE is 0 where rows have a time, whose column TIME names or is found.
int table(const std::string& file, const TableOptions& options) {
    const bool numpy = file.ends_with(".npz") || file.ends_with(".npy");
    const bool matlab = file.ends_with(".mat");
    if (!numpy && !matlab && options.columns.size() == 1 && has_scans(file, options.columns.front()))
        return scans(file, options.columns.front());
    const auto sent = file.ends_with(".npz") ? send_npz(file, options, say)
                      : numpy                ? send_npy(file, options, say)
                      : matlab               ? send_mat(file, options, say)
                                             : send_hdf5_columns(file, options, say);
    return sent ? EXIT_SUCCESS : refuse(sent.error().text);
}

int write(const std::string& file, Hdf5Format format, const NwbSession& session) {
    const auto set = event_set(standard_input());
    if (!set) return refuse(set.error().text);
    const auto written = format == Hdf5Format::sonata ? write_sonata(file, set.value())
                                                      : write_nwb(file, set.value(), session);
    return written ? EXIT_SUCCESS : refuse(written.error().text);
}

int run(const std::vector<std::string>& arguments) {
    if (arguments.size() == 6 && arguments[1] == "scans") {
        limit(std::stoull(arguments[3]), std::stoull(arguments[4]), false);
        return scans(arguments[2], arguments[5]);
    }
    if (arguments.size() >= 7 && arguments[1] == "table") {
        limit(std::stoull(arguments[3]), std::stoull(arguments[4]), false);
        TableOptions options{.columns = {arguments.begin() + 7, arguments.end()},
                             .time_column = arguments[6]};
        if (arguments[5] != "0") options.rate_hz = 1;
        return table(arguments[2], options);
    }
    const bool reads = arguments.size() == 5 && arguments[1] == "read";
    const bool writes = arguments.size() == 7 && arguments[1] == "write";
    const auto format = reads || writes ? hdf5_format_of(arguments[2]) : std::nullopt;
    if (!format)
        return refuse(
            "usage: afferent-hdf5 read FILE SECONDS MEGABYTES\n"
            "       afferent-hdf5 write FILE SECONDS MEGABYTES BEGAN_MS NOW_MS\n"
            "       afferent-hdf5 scans FILE SECONDS MEGABYTES DATASET\n"
            "       afferent-hdf5 table FILE SECONDS MEGABYTES RATE TIME [COLUMN...]\n"
            "The FILE of events ends in .sonata.h5 or .nwb. afferent starts this program.\n");
    limit(std::stoull(arguments[3]), std::stoull(arguments[4]), writes);
    if (reads) return read(arguments[2], *format);
    return write(arguments[2], *format,
                 {.description = "Address events converted by Afferent",
                  .start = since_1970(arguments[5].c_str()),
                  .created = since_1970(arguments[6].c_str())});
}

}  // namespace
}  // namespace afferent

int main(int argc, char** argv) {
    try {
        const int code = afferent::run({argv, argv + argc});
        // After a damaged file the library's own cleanup may fail as well: it is skipped.
        std::fflush(stdout);
        std::_Exit(code);
    } catch (const std::bad_alloc&) {
        return afferent::refuse("it takes more memory than a file of its size should");
    } catch (const std::exception& error) {
        return afferent::refuse(error.what());
    }
}
