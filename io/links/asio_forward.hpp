// Declares Asio's event loop, so that a header that only passes it on need not include Asio.
#pragma once

namespace boost::asio {

class io_context;

}  // namespace boost::asio
