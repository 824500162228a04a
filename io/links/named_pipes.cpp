#include "afferent/io/links/named_pipes.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <optional>
#include <system_error>
#include <utility>

#include "afferent/io/links/counted_stream.hpp"
#include "afferent/io/links/file_identity.hpp"
#include "afferent/io/links/pipe_pair.hpp"
#include "afferent/io/links/stream_connection.hpp"
#include "afferent/io/links/stream_transport.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::posix::stream_descriptor;
using boost::system::error_code;

// Every open is non-blocking. Whoever writes to a pipe opens it for reading as well (Linux allows that, see
// fifo(7)): a write then never meets a pipe without a reader, which would raise SIGPIPE. That a peer has gone
// is seen by the end of the pipe that is read.

std::string in_path(const std::string& path) { return path + ".in"; }
std::string out_path(const std::string& path) { return path + ".out"; }

std::string system_words() { return std::generic_category().message(errno); }

// Nothing if it is not a pipe of this user.
std::optional<FileIdentity> pipe_identity(const struct stat& status) {
    if (!S_ISFIFO(status.st_mode) || status.st_uid != ::geteuid()) return std::nullopt;
    return identity_of(status);
}
std::optional<FileIdentity> pipe_at(const std::string& path) {
    struct stat status {};
    return ::lstat(path.c_str(), &status) == 0 ? pipe_identity(status) : std::nullopt;
}

// A descriptor, closed with its owner. It is empty if opening failed; errno says why.
class OpenPipe {
  public:
    OpenPipe(const std::string& path, int flags)
        : descriptor_(::open(path.c_str(), flags | O_NONBLOCK | O_CLOEXEC | O_NOFOLLOW | O_NOCTTY)) {}
    ~OpenPipe() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    OpenPipe(const OpenPipe&) = delete;
    OpenPipe& operator=(const OpenPipe&) = delete;

    explicit operator bool() const noexcept { return descriptor_ >= 0; }
    bool lock() const { return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0; }
    std::optional<FileIdentity> identity() const {
        struct stat status {};
        return ::fstat(descriptor_, &status) == 0 ? pipe_identity(status) : std::nullopt;
    }
    // As small as the link's other buffers: what waits in a pipe is old before it is read.
    stream_descriptor stream(asio::io_context& io, const LinkOptions& options) {
        ::fcntl(descriptor_, F_SETPIPE_SZ, static_cast<int>(options.kernel_buffer_bytes));
        return {io, std::exchange(descriptor_, -1)};
    }

  private:
    int descriptor_;
};

std::shared_ptr<StreamPeer> pipe_connection(PipePair stream, const LinkOptions& options) {
    using Counted = CountedStream<PipePair>;
    return std::make_shared<StreamConnection<Counted>>(Counted(std::move(stream)), options);
}

// --- The listener's end.

// The name of a pipe made by this listener. It is removed with its owner if it still names that pipe.
class PipeName {
  public:
    explicit PipeName(std::string path) : path_(std::move(path)) {
        if (::mkfifo(path_.c_str(), S_IRUSR | S_IWUSR) == 0) pipe_ = pipe_at(path_);
    }
    ~PipeName() {
        if (pipe_ && pipe_ == pipe_at(path_)) ::unlink(path_.c_str());
    }
    PipeName(const PipeName&) = delete;
    PipeName& operator=(const PipeName&) = delete;

    // False: the pipe could not be made, and errno says why.
    bool made() const noexcept { return pipe_.has_value(); }
    const std::string& path() const noexcept { return path_; }

  private:
    std::string path_;
    std::optional<FileIdentity> pipe_;
};

// A pair of pipes that waits for its peer.
struct WaitingPair {
    // `out` first, and locked for as long as the pair lives: once `in` is there and open, a peer finds both.
    WaitingPair(asio::io_context& io, const std::string& path, const LinkOptions& options)
        : out_name(out_path(path)), in_name(in_path(path)), out(io), in(io) {
        if (!out_name.made() || !in_name.made()) return;
        OpenPipe out_pipe(out_name.path(), O_RDWR);
        if (!out_pipe || !out_pipe.lock()) return;
        OpenPipe in_pipe(in_name.path(), O_RDONLY);
        if (!in_pipe) return;
        out = out_pipe.stream(io, options);
        in = in_pipe.stream(io, options);
    }

    // Whether a peer has opened it: the writer to `in` holds its lock.
    bool taken() {
        const int descriptor = in.native_handle();
        if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return true;
        ::flock(descriptor, LOCK_UN);
        return false;
    }

    PipeName out_name;
    PipeName in_name;
    stream_descriptor out;
    stream_descriptor in;
};

// `unreachable` where the pipes cannot be made.
Result<std::unique_ptr<WaitingPair>> make_pair(asio::io_context& io, const PipesAddress& address,
                                               const LinkOptions& options) {
    auto pair = std::make_unique<WaitingPair>(io, address.path, options);
    if (!pair->in.is_open())
        return Error{Error::Kind::unreachable,
                     address.text() + ": the pipes cannot be made: " + system_words()};
    return pair;
}

// Removes the pipes that a killed listener has left behind. A listener that is alive holds the lock of its
// `out`.
Result<void> remove_abandoned(const PipesAddress& address) {
    for (const std::string& path : {out_path(address.path), in_path(address.path)}) {
        const auto refused = [&](const std::string& what) {
            return Error{Error::Kind::not_allowed, address.text() + ": " + path + " " + what};
        };
        struct stat status {};
        if (::lstat(path.c_str(), &status) != 0) continue;
        if (!S_ISFIFO(status.st_mode)) return refused("exists and is not a pipe; choose another path");
        const OpenPipe probe(path, O_RDONLY);
        if (!probe) return refused("cannot be opened: " + system_words());
        if (path == out_path(address.path) && !probe.lock()) return refused("is in use by another listener");
        if (::unlink(path.c_str()) != 0) return refused("cannot be replaced: " + system_words());
    }
    return success();
}

class PipeAcceptor final : public ConnectionAcceptor {
  public:
    PipeAcceptor(asio::io_context& io, const PipesAddress& address, std::unique_ptr<WaitingPair> pair,
                 const LinkOptions& options)
        : state_(std::make_shared<State>(io, address, std::move(pair), options)) {}
    ~PipeAcceptor() override {
        state_->on_peer = nullptr;
        state_->timer.cancel();
        state_->pair.reset();
    }
    PipeAcceptor(const PipeAcceptor&) = delete;
    PipeAcceptor& operator=(const PipeAcceptor&) = delete;

    void start(OnStreamPeer on_peer) override {
        state_->on_peer = std::move(on_peer);
        wait(state_);
        look_after(state_);
    }

  private:
    static constexpr std::chrono::milliseconds pause{250};
    // A peer that has opened the pair and written nothing is looked at this many times; then the next peer
    // gets a pair of its own.
    static constexpr int most_idle_looks = 4;

    // Outlives the acceptor until the operation under way has ended.
    struct State {
        State(asio::io_context& io_in, PipesAddress address_in, std::unique_ptr<WaitingPair> pair_in,
              const LinkOptions& options_in)
            : io(io_in),
              address(std::move(address_in)),
              pair(std::move(pair_in)),
              options(options_in),
              timer(io_in) {}

        asio::io_context& io;
        PipesAddress address;
        std::unique_ptr<WaitingPair> pair;
        LinkOptions options;
        asio::steady_timer timer;
        int idle_looks = 0;
        OnStreamPeer on_peer;  // empty: the acceptor is gone
    };

    static void look_after(const std::shared_ptr<State>& state) {
        state->timer.expires_after(pause);
        state->timer.async_wait([state](const error_code& error) {
            if (error || !state->on_peer) return;
            if (!state->pair) {
                open_next(state);
            } else if (!state->pair->taken()) {
                state->idle_looks = 0;
            } else if (++state->idle_looks == most_idle_looks) {
                state->pair.reset();
                open_next(state);
            }
            look_after(state);
        });
    }

    // A peer is there when it has written something: the coprocessor speaks first.
    static void wait(const std::shared_ptr<State>& state) {
        state->pair->in.async_wait(stream_descriptor::wait_read, [state](const error_code& error) {
            if (!error && state->on_peer) accept(state);
        });
    }

    // The next peer finds a pair of its own under the same names.
    static void accept(const std::shared_ptr<State>& state) {
        PipePair stream(std::move(state->pair->in), std::move(state->pair->out));
        state->pair.reset();
        open_next(state);
        // The callback may destroy the acceptor, and with it the function that is running.
        const auto on_peer = state->on_peer;
        on_peer(pipe_connection(std::move(stream), state->options));
    }

    // Where that fails, look_after() tries again.
    static void open_next(const std::shared_ptr<State>& state) {
        state->idle_looks = 0;
        auto made = make_pair(state->io, state->address, state->options);
        if (!made) return;
        state->pair = std::move(made).value();
        wait(state);
    }

    std::shared_ptr<State> state_;
};

// --- The other end.

Result<PipePair> open_pipes(asio::io_context& io, const std::string& path, const LinkOptions& options) {
    const auto unreachable = [](const std::string& text) { return Error{Error::Kind::unreachable, text}; };
    OpenPipe in(out_path(path), O_RDONLY);
    if (!in) return unreachable(system_words());
    // Fails where nobody has the pipe open for reading.
    const OpenPipe probe(in_path(path), O_WRONLY);
    if (!probe) return unreachable(errno == ENXIO ? "no listener has opened the pipes" : system_words());
    OpenPipe out(in_path(path), O_RDWR);
    if (!out) return unreachable(system_words());
    // Two coprocessors that look for a listener at the same time may find the same pair: the lock decides.
    // And the listener may have replaced the pair between two of our steps.
    if (!out.lock()) return unreachable("another coprocessor is just connecting");
    if (!in.identity() || in.identity() != pipe_at(out_path(path)) || !out.identity() ||
        out.identity() != probe.identity())
        return unreachable("the pipes are being replaced, or belong to another user");
    return PipePair(in.stream(io, options), out.stream(io, options));
}

class PipeAttempt final : public ConnectionAttempt {
  public:
    PipeAttempt(asio::io_context& io, PipesAddress address, const LinkOptions& options)
        : io_(io), address_(std::move(address)), options_(options) {}

    // Callbacks are called from the loop only, not from within this call.
    void start(OnStreamPeer on_connection) override {
        on_connection_ = std::make_shared<OnStreamPeer>(std::move(on_connection));
        // There is no callback if it was called off, or if its owner is gone.
        asio::post(io_, [this, weak = std::weak_ptr(on_connection_)] {
            if (const auto kept = weak.lock()) (*kept)(connect());
        });
    }
    void call_off() override { on_connection_.reset(); }

  private:
    Result<std::shared_ptr<StreamPeer>> connect() {
        AFFERENT_TRY(stream, open_pipes(io_, address_.path, options_));
        return pipe_connection(std::move(stream), options_);
    }

    asio::io_context& io_;
    PipesAddress address_;
    LinkOptions options_;
    std::shared_ptr<OnStreamPeer> on_connection_;  // empty: called off
};

}  // namespace

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const PipesAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(remove_abandoned(address));
    AFFERENT_TRY(pair, make_pair(io, address, options));
    return make_stream_listener(
        io, address, std::make_unique<PipeAcceptor>(io, address, std::move(pair), options), options);
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const PipesAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    return make_stream_connector(
        io, address, std::unique_ptr<ConnectionAttempt>(new PipeAttempt(io, address, options)), patience);
}

}  // namespace afferent
