#include "afferent/io/datagram_transports.hpp"

#include <boost/asio/post.hpp>

namespace afferent {
namespace {

Error not_there(const LinkAddress& address) {
    return {Error::Kind::not_allowed, text(address) + ": this transport is not there yet"};
}

class NoConnector final : public Connector {
  public:
    NoConnector(boost::asio::io_context& io, LinkAddress address) : io_(io), address_(std::move(address)) {}

    void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
        boost::asio::post(io_, [on_link, error = not_there(address_)] { on_link(error); });
    }

  private:
    boost::asio::io_context& io_;
    LinkAddress address_;
};

}  // namespace

Result<std::unique_ptr<Listener>> open_datagram_listener(boost::asio::io_context&, const UdpAddress& address,
                                                         const LinkOptions&) {
    return not_there(address);
}

Result<std::unique_ptr<Listener>> open_datagram_listener(boost::asio::io_context&,
                                                         const SerialAddress& address, const LinkOptions&) {
    return not_there(address);
}

std::unique_ptr<Connector> make_datagram_connector(boost::asio::io_context& io, const UdpAddress& address,
                                                   const Patience&, const LinkOptions&) {
    return std::make_unique<NoConnector>(io, address);
}

std::unique_ptr<Connector> make_datagram_connector(boost::asio::io_context& io, const SerialAddress& address,
                                                   const Patience&, const LinkOptions&) {
    return std::make_unique<NoConnector>(io, address);
}

}  // namespace afferent
