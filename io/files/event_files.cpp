#include "afferent/io/files/event_files.hpp"

#include <algorithm>
#include <array>
#include <boost/endian/conversion.hpp>
#include <charconv>
#include <limits>
#include <string>

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
void append(Bytes& out, std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    out.insert(out.end(), bytes.begin(), bytes.end());
}
const unsigned char* raw(std::span<const std::byte> bytes, std::size_t at) {
    return reinterpret_cast<const unsigned char*>(bytes.data() + at);
}

Error malformed(const std::string& text) { return {Error::Kind::malformed, text}; }
Error malformed_at(std::size_t byte, const char* text) {
    return malformed("byte " + std::to_string(byte) + ": " + text);
}

std::uint64_t microseconds(TimePoint time) {
    return static_cast<std::uint64_t>((time - scene_start) / Duration(1us));
}

// --- CSV. Not by TableReader, which wants rising times: several events may have the same.

void append_number(Bytes& out, std::uint64_t value, std::size_t width) {
    std::array<char, 20> digits;
    const auto* end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    const auto length = static_cast<std::size_t>(end - digits.data());
    if (length < width) out.insert(out.end(), width - length, std::byte{'0'});
    append(out, {digits.data(), length});
}

Bytes write_csv(std::span<const Event> events) {
    Bytes out;
    append(out, "time_s,address\n");
    for (const Event& event : events) {
        const auto ns = static_cast<std::uint64_t>((event.time - scene_start).count());
        append_number(out, ns / 1'000'000'000, 1);
        append(out, ".");
        append_number(out, ns % 1'000'000'000, 9);
        append(out, ",");
        append_number(out, event.address, 1);
        append(out, "\n");
    }
    return out;
}

// Integers, because a double does not hold nine decimals exactly.
bool read_seconds(std::string_view text, TimePoint& time) {
    std::uint64_t whole = 0;
    auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), whole);
    if (error != std::errc() || whole > 4'000'000'000) return false;
    std::uint64_t ns = 0;
    if (end != text.data() + text.size()) {
        if (*end != '.') return false;
        const std::string_view decimals(end + 1,
                                        static_cast<std::size_t>(text.data() + text.size() - end - 1));
        if (decimals.empty() || decimals.size() > 9) return false;
        std::string padded(decimals);
        padded.resize(9, '0');
        const auto [last, wrong] = std::from_chars(padded.data(), padded.data() + 9, ns);
        if (wrong != std::errc() || last != padded.data() + 9) return false;
    }
    time = scene_start + Duration(static_cast<std::int64_t>(whole * 1'000'000'000 + ns));
    return true;
}

Result<std::vector<Event>> read_csv(std::span<const std::byte> bytes) {
    std::string_view text = as_text(bytes);
    std::vector<Event> events;
    for (std::size_t line = 1; !text.empty(); ++line) {
        const auto wrong = [line](const char* what) {
            return malformed("line " + std::to_string(line) + ": " + what);
        };
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return wrong("is cut off");
        std::string_view row = text.substr(0, end);
        text.remove_prefix(end + 1);
        if (row.ends_with('\r')) row.remove_suffix(1);
        if (line == 1) {
            if (row != "time_s,address") return wrong("the header must be time_s,address");
            continue;
        }
        const std::size_t comma = row.find(',');
        if (comma == std::string_view::npos) return wrong("must have two columns");
        Event event{};
        if (!read_seconds(row.substr(0, comma), event.time))
            return wrong("time_s must be seconds with at most nine decimals");
        const std::string_view address = row.substr(comma + 1);
        const auto [last, error] =
            std::from_chars(address.data(), address.data() + address.size(), event.address);
        if (error != std::errc() || last != address.data() + address.size())
            return wrong("address must be a whole number below 2^32");
        events.push_back(event);
    }
    if (bytes.empty()) return malformed("line 1: the header must be time_s,address");
    return events;
}

// --- Event Stream 2.0, generic events.

constexpr std::string_view es_header{"Event Stream\x02\x00\x00\x00", 16};
constexpr std::uint8_t es_reset = 0xfe;
constexpr std::uint8_t es_overflow = 0xff;
constexpr std::uint64_t es_overflow_us = 0xfe;
constexpr std::uint8_t es_four_bytes = 4 << 1;  // one size byte, no more to come

Result<Bytes> write_es(std::span<const Event> events) {
    // Silence takes a byte for each 254 microseconds.
    constexpr std::uint64_t longest_us = es_overflow_us << 31;
    if (!events.empty() && microseconds(events.back().time) > longest_us)
        return Error{Error::Kind::not_allowed, "an Event Stream of more than 6 days takes more than 2 GB"};
    Bytes out;
    append(out, es_header);
    std::uint64_t last = 0;
    for (const Event& event : events) {
        const std::uint64_t now = microseconds(event.time);
        out.insert(out.end(), (now - last) / es_overflow_us, std::byte{es_overflow});
        out.push_back(static_cast<std::byte>((now - last) % es_overflow_us));
        out.push_back(std::byte{es_four_bytes});
        std::array<unsigned char, 4> address;
        boost::endian::store_little_u32(address.data(), event.address);
        for (const unsigned char byte : address) out.push_back(std::byte{byte});
        last = now;
    }
    return out;
}

Result<std::vector<Event>> read_es(std::span<const std::byte> bytes) {
    if (!as_text(bytes).starts_with(es_header.substr(0, 13)))
        return malformed_at(0, "not an Event Stream of version 2");
    if (bytes.size() < es_header.size() || bytes[15] != std::byte{0})
        return malformed_at(15, "not a stream of generic events");
    std::vector<Event> events;
    std::uint64_t now = 0;
    for (std::size_t at = es_header.size(); at < bytes.size();) {
        const auto byte = std::to_integer<std::uint8_t>(bytes[at]);
        ++at;
        if (byte == es_reset) continue;
        if (byte == es_overflow) {
            now += es_overflow_us;
            continue;
        }
        now += byte;
        if (bytes.size() - at < 5) return malformed_at(at, "ends within an event");
        if (bytes[at] != std::byte{es_four_bytes}) return malformed_at(at, "an address must have four bytes");
        events.push_back({scene_start + Duration(static_cast<std::int64_t>(now) * 1000),
                          boost::endian::load_little_u32(raw(bytes, at + 1))});
        at += 5;
    }
    return events;
}

// --- AEDAT 2.

constexpr std::string_view aedat_magic = "#!AER-DAT2.0";

Result<Bytes> write_aedat2(std::span<const Event> events) {
    if (!events.empty() && events.front().address >> 24 == '#')
        return Error{Error::Kind::not_allowed, "an AEDAT 2 file cannot begin with address " +
                                                   std::to_string(events.front().address) +
                                                   ", which readers take for a comment"};
    Bytes out;
    append(out, aedat_magic);
    append(out, "\r\n# int32 address, int32 timestamp in microseconds, both big-endian\r\n");
    for (const Event& event : events) {
        const std::uint64_t now = microseconds(event.time);
        if (now > std::numeric_limits<std::uint32_t>::max())
            return Error{Error::Kind::not_allowed,
                         "an AEDAT 2 file ends after 2^32 microseconds, 71 minutes"};
        std::array<unsigned char, 8> record;
        boost::endian::store_big_u32(record.data(), event.address);
        boost::endian::store_big_u32(record.data() + 4, static_cast<std::uint32_t>(now));
        for (const unsigned char byte : record) out.push_back(std::byte{byte});
    }
    return out;
}

Result<std::vector<Event>> read_aedat2(std::span<const std::byte> bytes) {
    const std::string_view text = as_text(bytes);
    if (!text.starts_with(aedat_magic)) return malformed_at(0, "not an AER-DAT file of version 2.0");
    // Comments end at the first line that does not begin with #. A first event could be taken for a comment
    // only if its address had 35 in the highest byte.
    std::size_t at = 0;
    while (at < text.size() && text[at] == '#') {
        const std::size_t end = text.find('\n', at);
        if (end == std::string_view::npos) return malformed_at(at, "ends within a comment");
        at = end + 1;
    }
    if ((bytes.size() - at) % 8 != 0) return malformed_at(bytes.size(), "ends within an event");
    std::vector<Event> events;
    for (; at < bytes.size(); at += 8)
        events.push_back({scene_start + Duration(1us) * boost::endian::load_big_u32(raw(bytes, at + 4)),
                          boost::endian::load_big_u32(raw(bytes, at))});
    return events;
}

}  // namespace

Result<EventFormat> format_of(const std::filesystem::path& file) {
    const std::string ending = file.extension().string();
    if (ending == ".csv") return EventFormat::csv;
    if (ending == ".es") return EventFormat::event_stream;
    if (ending == ".aedat") return EventFormat::aedat2;
    return Error{Error::Kind::not_allowed,
                 file.string() + ": the ending must be .csv, .es, .aedat, .sonata.h5 or .nwb"};
}

Result<std::vector<std::byte>> write_events(std::span<const Event> events, EventFormat format) {
    if (format == EventFormat::csv) return write_csv(events);
    if (format == EventFormat::event_stream) return write_es(events);
    return write_aedat2(events);
}

Result<std::vector<Event>> read_events(std::span<const std::byte> bytes, EventFormat format) {
    AFFERENT_TRY(events, format == EventFormat::csv            ? read_csv(bytes)
                         : format == EventFormat::event_stream ? read_es(bytes)
                                                               : read_aedat2(bytes));
    for (std::size_t i = 1; i < events.size(); ++i)
        if (events[i].time < events[i - 1].time)
            return malformed("event " + std::to_string(i + 1) + ": time runs backwards");
    // Events within one microsecond may be in any order.
    std::sort(events.begin(), events.end());
    return events;
}

}  // namespace afferent
