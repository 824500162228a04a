// Forward declaration of Asio's event loop. Included by headers that only pass it on.
#pragma once

namespace boost::asio {

class io_context;

}  // namespace boost::asio
