#include "afferent/io/links/transports.hpp"

namespace afferent {

Result<std::unique_ptr<Listener>> open_listener(boost::asio::io_context& io, const LinkAddress& address,
                                                const LinkOptions& options) {
    return std::visit([&](const auto& one) { return listen_on(io, one, options); }, address);
}

std::unique_ptr<Connector> make_connector(boost::asio::io_context& io, const LinkAddress& address,
                                          const Patience& patience, const LinkOptions& options) {
    return std::visit([&](const auto& one) { return connector_to(io, one, patience, options); }, address);
}

}  // namespace afferent
