// Composes a script for gnuplot of words, numbers, and quoted text that gnuplot does not interpret.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace afferent {

// A number as gnuplot reads it: seven digits, enough for any picture.
std::string gnuplot_number(double value);

// Quoted text to be drawn literally, or the name of a file. Nothing in it is taken for a command or a
// substitution; where it is drawn, `noenhanced` keeps it from being markup.
std::string gnuplot_text(std::string_view text);

// The same as one column of a block of data.
std::string gnuplot_data_text(std::string_view text);

class GnuplotScript {
  public:
    //     script.line("set yrange [0:", highest, "]");
    template <class... Parts>
    void line(const Parts&... parts) {
        (add(parts), ...);
        text_ += '\n';
    }
    void append(const GnuplotScript& other) { text_ += other.text_; }

    const std::string& text() const noexcept { return text_; }

  private:
    void add(std::string_view word) { text_ += word; }
    void add(char letter) { text_ += letter; }
    template <class Number>
    requires std::integral<Number> || std::floating_point<Number>
    void add(Number number) { text_ += gnuplot_number(static_cast<double>(number)); }

    std::string text_;
};

}  // namespace afferent
