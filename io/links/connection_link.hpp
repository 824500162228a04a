// The link that a session holds, over a connection that lives as long as its operations. For the transports.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "afferent/io/links/link.hpp"

namespace afferent {

// Outlives the link that a session holds until the operation under way has ended. Calls that a link has, too,
// mean what they mean there.
class Connection {
  public:
    virtual ~Connection() = default;

    virtual void start(LinkCallbacks callbacks) = 0;
    virtual bool send(const proto::Envelope& message) = 0;
    virtual void close() = 0;
    virtual std::size_t queued_bytes() const = 0;
    virtual bool ordered() const = 0;
    virtual const LinkCounts& counts() const = 0;

    // Neither closed nor failed.
    virtual bool lives() const = 0;
    // Closes at once, without another callback.
    virtual void abort() = 0;
};

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
    bool ordered() const override { return connection_->ordered(); }
    const LinkCounts& counts() const override { return connection_->counts(); }

  private:
    std::shared_ptr<Connection> connection_;
    bool closed_ = false;
};

}  // namespace afferent
