#include "afferent/io/links/relay.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/pseudo_terminal.hpp"
#include "afferent/io/links/relay_pipe.hpp"
#include "afferent/io/links/socket_transport.hpp"
#include "afferent/io/links/stream_cutter.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr std::size_t read_bytes = std::size_t{16} * 1024;
constexpr std::size_t most_connections = 16;

void add(ChannelCounts& sum, const ChannelCounts& more) {
    sum.sent += more.sent;
    sum.arrived += more.arrived;
    sum.lost += more.lost;
    sum.dropped += more.dropped;
    sum.duplicated += more.duplicated;
    sum.corrupted += more.corrupted;
    sum.reordered += more.reordered;
}

// The two ends of one stream, and the channel each way. Lives while one of its operations is under way.
template <class Stream>
class StreamRelayConnection : public std::enable_shared_from_this<StreamRelayConnection<Stream>> {
  public:
    using Closed = std::function<void()>;

    StreamRelayConnection(asio::io_context& io, Stream coprocessor, Stream hand, CutInto pieces,
                          const RelayParameters& parameters)
        : coprocessor_(std::move(coprocessor), pieces),
          hand_(std::move(hand), pieces),
          events_(parameters.events) {
        to_hand_ =
            std::make_shared<RelayPipe>(io, parameters.to_hand, [this](auto frame) { write(hand_, frame); });
        to_coprocessor_ = std::make_shared<RelayPipe>(io, parameters.to_coprocessor,
                                                      [this](auto frame) { write(coprocessor_, frame); });
        coprocessor_.pipe = to_hand_.get();
        hand_.pipe = to_coprocessor_.get();
    }

    void start(Closed closed) {
        closed_ = std::move(closed);
        read(coprocessor_);
        read(hand_);
    }

    void close() {
        is_closed_ = true;
        error_code ignored;
        coprocessor_.stream.close(ignored);
        hand_.stream.close(ignored);
        to_hand_->close();
        to_coprocessor_->close();
        if (closed_) closed_();
    }

    void pull(bool pulled) {
        to_hand_->pull(pulled);
        to_coprocessor_->pull(pulled);
    }

    const ChannelCounts& to_hand() const { return to_hand_->counts(); }
    const ChannelCounts& to_coprocessor() const { return to_coprocessor_->counts(); }

  private:
    struct End {
        End(Stream stream_in, CutInto pieces)
            : stream(std::move(stream_in)), cutter(pieces), space(read_bytes) {}

        Stream stream;
        StreamCutter cutter;
        std::vector<std::byte> space;
        RelayPipe* pipe = nullptr;   // for what comes from here
        std::vector<std::byte> out;  // for here, waiting
        std::vector<std::byte> writing;
        bool ended = false;  // it sends no more
    };

    bool full(const End& from, const End& to) const {
        return from.pipe->full() ||
               from.pipe->waiting_bytes() + to.out.size() + to.writing.size() > RelayPipe::most_waiting_bytes;
    }

    void read(End& from) {
        if (is_closed_) return;
        End& to = &from == &hand_ ? coprocessor_ : hand_;
        if (full(from, to)) return in_a_moment([this, &from] { read(from); });
        from.stream.async_read_some(
            asio::buffer(from.space.data(), from.space.size()),
            [self = this->shared_from_this(), &from](const error_code& error, std::size_t count) {
                self->has_read(from, error, count);
            });
    }

    // The channel delivers as time passes, which it does not report.
    void in_a_moment(std::function<void()> look_again) {
        const auto timer =
            std::make_shared<asio::steady_timer>(hand_.stream.get_executor(), std::chrono::milliseconds(1));
        timer->async_wait([self = this->shared_from_this(), timer,
                           look_again = std::move(look_again)](const error_code&) { look_again(); });
    }

    void has_read(End& from, const error_code& error, std::size_t count) {
        if (is_closed_) return;
        if (error) {
            from.ended = true;
            return close_when_delivered();
        }
        from.cutter.push(std::span(from.space).first(count), [&](std::span<const std::byte> frame) {
            from.pipe->send(frame, &from == &coprocessor_ && events_ ? events_(frame) : 0);
        });
        read(from);
    }

    void write(End& to, std::span<const std::byte> frame) {
        to.out.insert(to.out.end(), frame.begin(), frame.end());
        if (to.writing.empty()) write_next(to);
    }

    void write_next(End& to) {
        if (to.out.empty()) return;
        to.writing.swap(to.out);
        asio::async_write(to.stream, asio::buffer(to.writing.data(), to.writing.size()),
                          [self = this->shared_from_this(), &to](const error_code& error, std::size_t) {
                              to.writing.clear();
                              if (self->is_closed_) return;
                              if (error) return self->close();
                              self->write_next(to);
                          });
    }

    // What an end sent before it closed still arrives.
    void close_when_delivered() {
        if (is_closed_) return;
        const auto delivered = [](const End& from, const End& to) {
            return !from.ended || (from.pipe->empty() && to.out.empty() && to.writing.empty());
        };
        if (delivered(coprocessor_, hand_) && delivered(hand_, coprocessor_)) return close();
        in_a_moment([this] { close_when_delivered(); });
    }

    End coprocessor_;
    End hand_;
    std::function<std::uint32_t(std::span<const std::byte>)> events_;
    std::shared_ptr<RelayPipe> to_hand_;
    std::shared_ptr<RelayPipe> to_coprocessor_;
    Closed closed_;
    bool is_closed_ = false;
};

// Each connection gets random numbers of its own.
RelayParameters parameters_of(const RelayParameters& parameters, std::uint64_t connection) {
    RelayParameters own = parameters;
    own.to_hand.seed += 2 * connection;
    own.to_coprocessor.seed += 2 * connection + 1;
    return own;
}

class SocketRelay final : public Relay {
  public:
    SocketRelay(asio::io_context& io, std::shared_ptr<StreamAcceptor> acceptor, const StreamEndpoint& hand,
                const LinkAddress& address, CutInto pieces, const RelayParameters& parameters)
        : state_(std::make_shared<State>(io, std::move(acceptor), hand, pieces, parameters)),
          address_(bound_address(*state_->acceptor, address)) {
        if (const auto* const local = std::get_if<UnixAddress>(&address_)) file_.emplace(local->path);
        accept_each(state_->acceptor,
                    [state = state_](StreamSocket socket) { reach_hand(state, std::move(socket)); });
    }
    ~SocketRelay() override {
        file_.reset();
        error_code ignored;
        state_->acceptor->close(ignored);
        for (const auto& connection : std::exchange(state_->connections, {})) connection->close();
    }

    LinkAddress address() const override { return address_; }
    RelayCounts counts() const override {
        RelayCounts counts = state_->ended;
        for (const auto& connection : state_->connections) count(*connection, counts);
        return counts;
    }
    void pull(bool pulled) override {
        state_->pulled = pulled;
        for (const auto& connection : state_->connections) connection->pull(pulled);
    }

  private:
    using RelayConnection = StreamRelayConnection<StreamSocket>;

    struct State {
        State(asio::io_context& io_in, std::shared_ptr<StreamAcceptor> acceptor_in,
              const StreamEndpoint& hand_in, CutInto pieces_in, const RelayParameters& parameters_in)
            : io(io_in),
              acceptor(std::move(acceptor_in)),
              hand(hand_in),
              pieces(pieces_in),
              parameters(parameters_in) {}

        asio::io_context& io;
        std::shared_ptr<StreamAcceptor> acceptor;
        StreamEndpoint hand;
        CutInto pieces;
        RelayParameters parameters;
        bool pulled = false;
        std::size_t reaching = 0;  // connections to come, for which the hand is still looked for
        std::vector<std::shared_ptr<RelayConnection>> connections;
        RelayCounts ended;
    };

    static void count(const RelayConnection& connection, RelayCounts& counts) {
        add(counts.to_hand, connection.to_hand());
        add(counts.to_coprocessor, connection.to_coprocessor());
    }

    // If the hand cannot be reached, the connection ends at once, and the coprocessor tries again.
    static void reach_hand(const std::shared_ptr<State>& state, StreamSocket coprocessor) {
        if (state->connections.size() + state->reaching == most_connections) return;
        ++state->reaching;
        const auto hand = std::make_shared<StreamSocket>(state->io);
        const auto waiting = std::make_shared<StreamSocket>(std::move(coprocessor));
        hand->async_connect(state->hand, [state, hand, waiting](const error_code& error) {
            --state->reaching;
            if (error || !state->acceptor->is_open()) return;
            tune(*waiting, LinkOptions());
            tune(*hand, LinkOptions());
            const auto connection = std::make_shared<RelayConnection>(
                state->io, std::move(*waiting), std::move(*hand), state->pieces,
                parameters_of(state->parameters, state->ended.connections++));
            connection->pull(state->pulled);
            state->connections.push_back(connection);
            connection->start([state, gone = std::weak_ptr(connection)] {
                const auto found =
                    std::find(state->connections.begin(), state->connections.end(), gone.lock());
                if (found == state->connections.end()) return;
                count(**found, state->ended);
                state->connections.erase(found);
            });
        });
    }

    std::shared_ptr<State> state_;
    LinkAddress address_;
    std::optional<SocketFile> file_;  // of a Unix socket
};

// The last sender is taken for the coprocessor. Each new one gets its own socket towards the hand, so that
// the hand can tell them apart.
class UdpRelay final : public Relay {
  public:
    UdpRelay(asio::io_context& io, udp::socket socket, udp::endpoint hand, const RelayParameters& parameters)
        : state_(std::make_shared<State>(io, std::move(socket), std::move(hand), parameters)) {
        const auto state = state_;
        state->to_hand =
            std::make_shared<RelayPipe>(io, parameters.to_hand, [state = state.get()](auto datagram) {
                error_code ignored;
                if (state->upstream)
                    state->upstream->send(asio::buffer(datagram.data(), datagram.size()), 0, ignored);
            });
        state->to_coprocessor =
            std::make_shared<RelayPipe>(io, parameters.to_coprocessor, [state = state.get()](auto datagram) {
                error_code ignored;
                state->socket.send_to(asio::buffer(datagram.data(), datagram.size()), state->coprocessor, 0,
                                      ignored);
            });
        read(state);
    }
    ~UdpRelay() override {
        error_code ignored;
        state_->socket.close(ignored);
        if (state_->upstream) state_->upstream->close(ignored);
        state_->to_hand->close();
        state_->to_coprocessor->close();
    }

    LinkAddress address() const override {
        const auto endpoint = state_->socket.local_endpoint();
        return UdpAddress{endpoint.address().to_string(), endpoint.port(), {}};
    }
    RelayCounts counts() const override {
        return {state_->to_hand->counts(), state_->to_coprocessor->counts(), state_->connections};
    }
    void pull(bool pulled) override {
        state_->to_hand->pull(pulled);
        state_->to_coprocessor->pull(pulled);
    }

  private:
    static constexpr std::size_t longest_datagram = std::size_t{64} * 1024;

    struct State {
        State(asio::io_context& io_in, udp::socket socket_in, udp::endpoint hand_in,
              const RelayParameters& parameters)
            : io(io_in),
              socket(std::move(socket_in)),
              hand(std::move(hand_in)),
              events(parameters.events),
              from_coprocessor(longest_datagram),
              from_hand(longest_datagram) {}

        asio::io_context& io;
        udp::socket socket;
        udp::endpoint hand;
        udp::endpoint coprocessor;
        udp::endpoint sender;
        std::shared_ptr<udp::socket> upstream;
        std::function<std::uint32_t(std::span<const std::byte>)> events;
        std::shared_ptr<RelayPipe> to_hand;
        std::shared_ptr<RelayPipe> to_coprocessor;
        std::vector<std::byte> from_coprocessor;
        std::vector<std::byte> from_hand;
        std::uint64_t connections = 0;
    };

    static void read(const std::shared_ptr<State>& state) {
        state->socket.async_receive_from(asio::buffer(state->from_coprocessor.data(), longest_datagram),
                                         state->sender, [state](const error_code& error, std::size_t count) {
                                             if (!state->socket.is_open()) return;
                                             if (!error)
                                                 from_coprocessor(
                                                     state, std::span(state->from_coprocessor).first(count));
                                             read(state);
                                         });
    }

    static void from_coprocessor(const std::shared_ptr<State>& state, std::span<const std::byte> datagram) {
        if (!state->upstream || state->sender != state->coprocessor) {
            const auto upstream = std::make_shared<udp::socket>(state->io);
            error_code error;
            upstream->connect(state->hand, error);
            if (!error) upstream->non_blocking(true, error);
            if (error) return;
            if (state->upstream) state->upstream->close(error);
            state->upstream = upstream;
            state->coprocessor = state->sender;
            ++state->connections;
            read_upstream(state, upstream);
        }
        if (state->to_hand->full()) return;
        state->to_hand->send(datagram, state->events ? state->events(datagram) : 0);
    }

    static void read_upstream(const std::shared_ptr<State>& state,
                              const std::shared_ptr<udp::socket>& upstream) {
        upstream->async_receive(asio::buffer(state->from_hand.data(), longest_datagram),
                                [state, upstream](const error_code& error, std::size_t count) {
                                    if (!upstream->is_open() || upstream != state->upstream) return;
                                    // A hand that does not listen yet shows as a refused connection.
                                    if (!error && !state->to_coprocessor->full())
                                        state->to_coprocessor->send(std::span(state->from_hand).first(count),
                                                                    0);
                                    read_upstream(state, upstream);
                                });
    }

    std::shared_ptr<State> state_;
};

class SerialRelay final : public Relay {
  public:
    SerialRelay(asio::io_context& io, SerialAddress address, NamedTerminal coprocessor, NamedTerminal hand,
                const RelayParameters& parameters)
        : address_(std::move(address)),
          coprocessor_(std::move(coprocessor)),
          hand_(std::move(hand)),
          connection_(std::make_shared<StreamRelayConnection<asio::posix::stream_descriptor>>(
              io, coprocessor_.take_ours(), hand_.take_ours(), CutInto::segments, parameters)) {
        connection_->start({});
    }
    ~SerialRelay() override { connection_->close(); }

    LinkAddress address() const override { return address_; }
    RelayCounts counts() const override { return {connection_->to_hand(), connection_->to_coprocessor(), 1}; }
    void pull(bool pulled) override { connection_->pull(pulled); }

  private:
    SerialAddress address_;
    NamedTerminal coprocessor_;
    NamedTerminal hand_;
    std::shared_ptr<StreamRelayConnection<asio::posix::stream_descriptor>> connection_;
};

// Opens a relay for each kind of address that the hand can have.
struct Open {
    asio::io_context& io;
    const LinkAddress& from;
    const RelayParameters& parameters;

    Result<std::unique_ptr<Relay>> operator()(const UnixAddress& to) const {
        if (const auto* const own = std::get_if<UnixAddress>(&from)) remove_if_abandoned(io, own->path);
        return socket_relay(to, CutInto::frames);
    }
    Result<std::unique_ptr<Relay>> operator()(const TcpAddress& to) const {
        return socket_relay(to, CutInto::frames);
    }
    Result<std::unique_ptr<Relay>> operator()(const TlsAddress& to) const {
        return socket_relay(to, CutInto::reads);
    }
    Result<std::unique_ptr<Relay>> operator()(const UdpAddress& to) const {
        const auto* const own = std::get_if<UdpAddress>(&from);
        if (!own) return differ(to);
        AFFERENT_TRY(here, endpoint_of(*own));
        AFFERENT_TRY(there, endpoint_of(to));
        udp::socket socket(io);
        error_code error;
        socket.open(here.protocol(), error);
        if (!error) socket.bind(here, error);
        if (!error) socket.non_blocking(true, error);
        if (error) return system_error(Error::Kind::unreachable, from, error);
        return std::unique_ptr<Relay>(new UdpRelay(io, std::move(socket), there, parameters));
    }
    Result<std::unique_ptr<Relay>> operator()(const SerialAddress& to) const {
        const auto* const own = std::get_if<SerialAddress>(&from);
        if (!own) return differ(to);
        AFFERENT_TRY(coprocessor, NamedTerminal::open(io, own->device));
        AFFERENT_TRY(hand, NamedTerminal::open(io, to.device));
        RelayParameters line = parameters;
        // Eight bits of each byte, between a start and a stop bit.
        const double bits_per_second = 0.8 * to.baud;
        for (ChannelParameters* way : {&line.to_hand, &line.to_coprocessor})
            if (way->bandwidth_bps <= 0 || way->bandwidth_bps > bits_per_second)
                way->bandwidth_bps = bits_per_second;
        return std::unique_ptr<Relay>(
            new SerialRelay(io, *own, std::move(coprocessor), std::move(hand), line));
    }

    // Any other transport.
    template <class Address>
    Result<std::unique_ptr<Relay>> operator()(const Address& to) const {
        return Error{Error::Kind::not_allowed,
                     to.text() + ": a channel cannot stand between two ends of this kind; use unix or tcp"};
    }

    template <class Address>
    Result<std::unique_ptr<Relay>> socket_relay(const Address& to, CutInto pieces) const {
        const auto* const own = std::get_if<Address>(&from);
        if (!own) return differ(to);
        AFFERENT_TRY(here, endpoint_of(*own));
        AFFERENT_TRY(there, endpoint_of(to));
        const auto acceptor = std::make_shared<StreamAcceptor>(io);
        if (const error_code error = listen(*acceptor, here))
            return system_error(Error::Kind::unreachable, from, error);
        return std::unique_ptr<Relay>(new SocketRelay(io, acceptor, there, from, pieces, parameters));
    }

    Error differ(const LinkAddress& to) const {
        return {Error::Kind::not_allowed,
                text(from) + " and " + text(to) +
                    " are different kinds of link; a channel needs the same at both ends"};
    }
};

}  // namespace

Result<std::unique_ptr<Relay>> Relay::open(asio::io_context& io, const LinkAddress& from,
                                           const LinkAddress& to, const RelayParameters& parameters) {
    return std::visit(Open{io, from, parameters}, to);
}

LinkAddress channel_address(const LinkAddress& hand) {
    LinkAddress channel = hand;
    std::visit(
        []<class Address>(Address& address) {
            if constexpr (requires { address.path; })
                address.path += ".channel";
            else if constexpr (requires { address.device; })
                address.device += ".channel";
            else
                address.port = static_cast<std::uint16_t>(address.port + 1);
        },
        channel);
    return channel;
}

}  // namespace afferent
