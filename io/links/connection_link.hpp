// The link that a session holds, over a connection that lives as long as its operations. For the transports.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "afferent/io/links/link.hpp"

namespace afferent {

// A connection has what a link has, and besides: `is_ordered`, and abort(), which closes at once.
template <class Connection>
class ConnectionLink final : public Link {
  public:
    explicit ConnectionLink(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}
    ~ConnectionLink() override {
        if (!closed_) connection_->abort();
    }

    void start(LinkCallbacks callbacks) override { connection_->start(std::move(callbacks)); }
    bool send(const proto::Envelope& message) override { return connection_->send(message); }
    void close() override {
        closed_ = true;
        connection_->close();
    }
    std::size_t queued_bytes() const override { return connection_->queued_bytes(); }
    bool ordered() const override { return Connection::is_ordered; }
    const LinkCounts& counts() const override { return connection_->counts(); }

  private:
    std::shared_ptr<Connection> connection_;
    bool closed_ = false;
};

}  // namespace afferent
