// Sockets that carry streams, whatever their family: listens on one and accepts one peer after another.
#pragma once

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/file_identity.hpp"
#include "afferent/io/links/link_address.hpp"

namespace afferent {

using StreamSocket = boost::asio::generic::stream_protocol::socket;
using StreamEndpoint = boost::asio::generic::stream_protocol::endpoint;
using StreamAcceptor = boost::asio::basic_socket_acceptor<boost::asio::generic::stream_protocol>;

boost::system::error_code listen(StreamAcceptor& acceptor, const StreamEndpoint& endpoint);

// Hands over each socket until the acceptor is closed, which the callback may do. However many peers connect,
// a limited number is accepted at once and in a second: the others wait in the system's queue, and do not
// hold up others on the same loop. If no peer can be accepted, usually for want of descriptors, it pauses as
// well.
void accept_each(const std::shared_ptr<StreamAcceptor>& acceptor, std::function<void(StreamSocket)> take);

// The address that the acceptor is bound to: this one, with the port that was found for port 0.
LinkAddress bound_address(const StreamAcceptor& acceptor, const LinkAddress& address);

// The file of a Unix socket that has just been bound. It is removed with its owner, unless another socket's
// file has taken its place: destroy this before the socket.
class SocketFile {
  public:
    explicit SocketFile(std::string path);
    ~SocketFile();
    SocketFile(SocketFile&& other) noexcept : path_(std::exchange(other.path_, {})), file_(other.file_) {}
    SocketFile& operator=(SocketFile&&) = delete;

  private:
    std::string path_;  // empty: moved from
    FileIdentity file_;
};

// A socket's file may have been left behind by a listener that was killed. It is removed if nobody listens
// there.
void remove_if_abandoned(boost::asio::io_context& io, const std::string& path);

}  // namespace afferent
