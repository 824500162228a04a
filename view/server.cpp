#include "afferent/view/server.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/waiting_line.hpp"
#include "afferent/view/access.hpp"
#include "afferent/view/embedded_files.hpp"
#include "afferent/view/messages.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using ViewStream = beast::basic_stream<asio::generic::stream_protocol>;

using HttpRequest = http::request<http::empty_body>;
using HttpResponse = http::response<http::string_body>;
using Text = std::shared_ptr<const std::string>;

// A viewer sends nothing but control frames.
constexpr std::size_t most_bytes_of_a_viewer = 1024;
// What the system holds back for a viewer that does not read.
constexpr int send_buffer_bytes = 256 << 10;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

std::vector<std::string_view> all(const HttpRequest& request, http::field field) {
    std::vector<std::string_view> values;
    const auto [begin, end] = request.equal_range(field);
    for (auto it = begin; it != end; ++it) values.push_back(view_of(it->value()));
    return values;
}

const char* type_of(std::string_view file) {
    return file.ends_with(".js")    ? "text/javascript; charset=utf-8"
           : file.ends_with(".css") ? "text/css; charset=utf-8"
                                    : "text/html; charset=utf-8";
}

const char* explanation(unsigned status) {
    switch (status) {
        case 403:
            return "This view is shown only at the address that the program has printed, on 127.0.0.1 or "
                   "localhost with\nthe same port.\n";
        case 404:
            return "There is nothing here. The program has printed the address of its view; a program that "
                   "is started\nagain may have another.\n";
        case 503:
            return "Too many look at this view already.\n";
        default:
            return "Not understood.\n";
    }
}

}  // namespace

struct ViewServer::State {
    class Place;
    class Request;
    class Viewer;

    State(const Limits& limits_in, Source source_in) : limits(limits_in), source(std::move(source_in)) {}
    ~State() {
        if (!thread.joinable()) return;
        asio::post(io, [this] { end(); });
        thread.join();
    }

    void take(StreamSocket socket);
    void tell_news(bool last);
    void wait_for_news();
    void end();
    void end_if_all_are_gone() {
        if (ending && viewers.empty() && !io.stopped()) io.stop();
    }

    const Limits limits;
    Source source;
    std::optional<ViewAccess> access;
    std::uint16_t port = 0;
    bool ending = false;
    std::vector<Viewer*> viewers;
    std::atomic<std::size_t> viewer_count{0};
    std::atomic<std::size_t> requests{0};
    std::atomic<std::uint64_t> dropped{0};
    std::atomic<std::size_t> waiting_bytes{0};
    // Destroyed first: what waits in it refers to the above.
    asio::io_context io{1};
    const std::shared_ptr<StreamAcceptor> acceptor = std::make_shared<StreamAcceptor>(io);
    const std::shared_ptr<WaitingLine> strangers =
        std::make_shared<WaitingLine>(io, limits.requests, limits.for_a_request);
    const std::shared_ptr<WaitingLine> guests =
        std::make_shared<WaitingLine>(io, limits.requests, limits.for_a_request);
    asio::steady_timer timer{io};
    std::thread thread;
};

// A connection's place in the line, which it leaves with this.
class ViewServer::State::Place {
  public:
    Place(std::shared_ptr<WaitingLine> line, std::function<void()> turn_away)
        : line_(std::move(line)), place_(line_->enter(std::move(turn_away))) {}
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    ~Place() { line_->leave(place_); }

  private:
    std::shared_ptr<WaitingLine> line_;
    WaitingLine::Place place_;
};

// A viewer's WebSocket. It lives as long as something is asked of the socket.
class ViewServer::State::Viewer : public std::enable_shared_from_this<Viewer> {
  public:
    Viewer(State& state, ViewStream stream) : state_(state), socket_(std::move(stream)) {
        state_.viewers.push_back(this);
        ++state_.viewer_count;
    }
    ~Viewer() {
        state_.waiting_bytes -= waiting_bytes_;
        std::erase(state_.viewers, this);
        --state_.viewer_count;
        state_.end_if_all_are_gone();
    }

    void begin(const HttpRequest& request) {
        beast::get_lowest_layer(socket_).expires_never();
        websocket::stream_base::timeout timeout{};
        timeout.handshake_timeout = state_.limits.for_a_request;
        timeout.idle_timeout = state_.limits.for_a_sign_of_life;
        timeout.keep_alive_pings = true;
        socket_.set_option(timeout);
        socket_.read_message_max(most_bytes_of_a_viewer);
        socket_.text(true);
        socket_.auto_fragment(false);
        socket_.async_accept(request, [self = shared_from_this()](const error_code& error) {
            if (error) return;
            self->open_ = true;
            self->send({std::make_shared<const std::string>(self->state_.source.greeting()), true});
            self->listen();
        });
    }

    struct Message {
        Text text;
        bool begins_course = false;
    };
    void send(Message message) {
        // Before the handshake is done there is nothing to miss: the greeting will tell.
        if (!open_) return;
        if (message.begins_course)
            while (!waiting_.empty()) drop(waiting_.begin());
        count(message.text->size());
        waiting_.push_back(std::move(message));
        keep_within_limits();
        write();
    }

    // Closes the connection once everything has been sent.
    void finish() {
        finishing_ = true;
        write();
    }

  private:
    using Waiting = std::deque<Message>;

    void count(std::size_t bytes) {
        waiting_bytes_ += bytes;
        state_.waiting_bytes += bytes;
    }
    void discount(std::size_t bytes) {
        waiting_bytes_ -= bytes;
        state_.waiting_bytes -= bytes;
    }
    void drop(Waiting::iterator message) {
        discount(message->text->size());
        waiting_.erase(message);
    }

    void keep_within_limits() {
        while (waiting_.size() > state_.limits.waiting_messages ||
               (waiting_.size() > 1 && waiting_bytes_ > state_.limits.waiting_bytes)) {
            const auto oldest =
                std::ranges::find_if(waiting_, [](const Message& each) { return !each.begins_course; });
            if (oldest == waiting_.end()) return;
            drop(oldest);
            ++dropped_;
            ++state_.dropped;
        }
    }

    void write() {
        if (sending_ || !open_) return;
        if (dropped_ != told_dropped_ && !waiting_.empty() && !waiting_.front().begins_course) {
            told_dropped_ = dropped_;
            sending_ = std::make_shared<const std::string>(dropped_message(dropped_));
        } else if (!waiting_.empty()) {
            sending_ = std::move(waiting_.front().text);
            waiting_.pop_front();
            discount(sending_->size());
        } else {
            if (finishing_) close();
            return;
        }
        socket_.async_write(asio::buffer(*sending_),
                            [self = shared_from_this()](const error_code& error, std::size_t) {
                                self->sending_.reset();
                                if (!error) self->write();
                            });
    }

    void close() {
        if (std::exchange(closing_, true)) return;
        socket_.async_close(websocket::close_code::going_away,
                            [self = shared_from_this()](const error_code&) {});
    }

    // A message from a viewer, or its end, ends the connection.
    void listen() {
        socket_.async_read(input_, [self = shared_from_this()](const error_code&, std::size_t) {
            beast::get_lowest_layer(self->socket_).close();
        });
    }

    State& state_;
    websocket::stream<ViewStream> socket_;
    beast::flat_buffer input_;
    Waiting waiting_;
    std::size_t waiting_bytes_ = 0;
    Text sending_;
    std::uint64_t dropped_ = 0;
    std::uint64_t told_dropped_ = 0;
    bool open_ = false;
    bool finishing_ = false;
    bool closing_ = false;
};

// A connection up to its answer: one request, and no other on the same connection. Whoever has not shown the
// token waits in another line than those who have, and cannot take their places.
class ViewServer::State::Request : public std::enable_shared_from_this<Request> {
  public:
    Request(State& state, StreamSocket socket) : state_(state), stream_(std::move(socket)) {
        parser_.body_limit(0);
        ++state_.requests;
    }
    ~Request() { --state_.requests; }

    void begin() {
        wait_in(state_.strangers);
        asio::async_read_until(stream_, asio::dynamic_buffer(input_, state_.limits.header_bytes), end_of_head,
                               [self = shared_from_this()](const error_code& error, std::size_t size) {
                                   if (!error) self->take_head(size);
                               });
    }

  private:
    static constexpr std::string_view end_of_head = "\r\n\r\n";

    void wait_in(const std::shared_ptr<WaitingLine>& line) {
        place_.emplace(line, [weak = weak_from_this()] {
            if (const auto self = weak.lock()) self->stream_.close();
        });
    }

    void take_head(std::size_t size) {
        error_code error;
        parser_.put(asio::buffer(input_.data(), size), error);
        if (error || !parser_.is_done()) return;
        if (!is_unambiguous({input_.data(), size - end_of_head.size()}))
            return send(400, explanation(400), "text/plain");
        answer();
    }

    void answer() {
        const HttpRequest& request = parser_.get();
        const ViewAccess::Answer answer = (*state_.access)({.method = view_of(request.method_string()),
                                                            .target = view_of(request.target()),
                                                            .hosts = all(request, http::field::host),
                                                            .origins = all(request, http::field::origin),
                                                            .upgrades = websocket::is_upgrade(request)});
        if (answer.status != 200) return send(answer.status, explanation(answer.status), "text/plain");
        wait_in(state_.guests);
        if (answer.is_socket) {
            if (state_.viewers.size() >= state_.limits.viewers)
                return send(503, explanation(503), "text/plain");
            place_.reset();
            return std::make_shared<Viewer>(state_, std::move(stream_))->begin(request);
        }
        for (const auto& [name, content] : embedded_files())
            if (name == answer.file) return send(200, content, type_of(name));
        send(404, explanation(404), "text/plain");
    }

    void send(unsigned status, std::string_view content, const char* type) {
        const HttpRequest& request = parser_.get();
        response_.result(status);
        response_.version(11);
        response_.keep_alive(false);
        response_.set(http::field::content_type, type);
        response_.set(http::field::cache_control, "no-store");
        response_.set("X-Content-Type-Options", "nosniff");
        response_.set("X-Frame-Options", "DENY");
        response_.set("Referrer-Policy", "no-referrer");
        response_.set("Cross-Origin-Opener-Policy", "same-origin");
        response_.set("Cross-Origin-Resource-Policy", "same-origin");
        // The host has been checked where the status is 200; otherwise it is not repeated.
        response_.set("Content-Security-Policy", status == 200
                                                     ? content_policy(view_of(request[http::field::host]))
                                                     : "default-src 'none'");
        response_.body() = content;
        response_.prepare_payload();
        http::async_write(stream_, response_, [self = shared_from_this()](const error_code&, std::size_t) {
            error_code ignored;
            self->stream_.socket().shutdown(StreamSocket::shutdown_send, ignored);
        });
    }

    State& state_;
    std::optional<Place> place_;
    ViewStream stream_;
    std::string input_;
    http::request_parser<http::empty_body> parser_;
    HttpResponse response_;
};

void ViewServer::State::take(StreamSocket socket) {
    error_code ignored;
    socket.set_option(asio::socket_base::send_buffer_size(send_buffer_bytes), ignored);
    socket.set_option(tcp::no_delay(true), ignored);
    std::make_shared<Request>(*this, std::move(socket))->begin();
}

void ViewServer::State::tell_news(bool last) {
    for (ViewMessage& message : source.news(last)) {
        const auto text = std::make_shared<const std::string>(std::move(message.text));
        for (Viewer* const viewer : viewers) viewer->send({text, message.begins_course});
    }
}

void ViewServer::State::wait_for_news() {
    timer.expires_after(limits.between_messages);
    timer.async_wait([this](const error_code& error) {
        if (error) return;
        tell_news(false);
        wait_for_news();
    });
}

void ViewServer::State::end() {
    ending = true;
    error_code ignored;
    acceptor->close(ignored);
    timer.expires_after(limits.for_the_last_messages);
    timer.async_wait([this](const error_code&) { io.stop(); });
    tell_news(true);
    for (Viewer* const viewer : viewers) viewer->finish();
    end_if_all_are_gone();
}

ViewServer::ViewServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
ViewServer::~ViewServer() = default;

Result<std::unique_ptr<ViewServer>> ViewServer::open(const std::string& token, std::uint16_t port,
                                                     const Limits& limits, Source source) {
    auto state = std::make_unique<State>(limits, std::move(source));
    const tcp::endpoint at(asio::ip::address_v4::loopback(), port);
    error_code error = listen(*state->acceptor, at);
    if (error)
        return Error{Error::Kind::unreachable,
                     "view: port " + std::to_string(port) + " on 127.0.0.1: " + error.message()};
    state->port = std::get<TcpAddress>(bound_address(*state->acceptor, TcpAddress{})).port;
    state->access.emplace(token, state->port);
    accept_each(state->acceptor, [raw = state.get()](StreamSocket socket) { raw->take(std::move(socket)); });
    state->wait_for_news();
    state->thread = std::thread([&io = state->io] { io.run(); });
    return std::unique_ptr<ViewServer>(new ViewServer(std::move(state)));
}

std::string ViewServer::url() const { return state_->access->url(); }
std::uint16_t ViewServer::port() const { return state_->port; }

ViewServer::Counts ViewServer::counts() const noexcept {
    return {.viewers = state_->viewer_count,
            .connections = state_->viewer_count + state_->requests,
            .dropped_messages = state_->dropped,
            .waiting_bytes = state_->waiting_bytes};
}

}  // namespace afferent
