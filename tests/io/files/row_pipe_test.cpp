#include "afferent/io/files/row_pipe.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

class RowPipes : public testing::Test {
  protected:
    RowPipes() : path_(fs::temp_directory_path() / ("afferent-rows-" + std::to_string(::getpid()))) {
        EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
        ::signal(SIGPIPE, SIG_IGN);
    }
    ~RowPipes() override {
        leave();
        fs::remove(path_);
    }

    void read_from_here_on() { reader_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK); }
    void leave() {
        if (reader_ >= 0) ::close(reader_);
        reader_ = -1;
    }
    std::string read() const {
        std::string all;
        std::array<char, 4096> some_bytes{};
        for (ssize_t count = 0; (count = ::read(reader_, some_bytes.data(), some_bytes.size())) > 0;)
            all.append(some_bytes.data(), static_cast<std::size_t>(count));
        return all;
    }

    fs::path path_;
    int reader_ = -1;
};

TEST_F(RowPipes, GiveTheirReaderTheHeadAndEveryRow) {
    read_from_here_on();
    RowPipe pipe(path_, "head\n");
    EXPECT_TRUE(pipe.has_reader());
    pipe.put("1\n");
    pipe.put("2\n");
    EXPECT_TRUE(pipe.finish(milliseconds(0)));
    EXPECT_EQ(read(), "head\n1\n2\n");
    EXPECT_EQ(pipe.lost_rows(), 0U);
}

TEST_F(RowPipes, LoseWhatComesWhileNobodyReadsThem) {
    RowPipe pipe(path_, "head\n");
    EXPECT_FALSE(pipe.has_reader());
    EXPECT_EQ(pipe.error(), 0);
    pipe.put("1\n");
    read_from_here_on();
    pipe.put("2\n");
    EXPECT_EQ(read(), "head\n2\n");
    leave();
    pipe.put("3\n");
    pipe.put("4\n");
    read_from_here_on();
    pipe.put("5\n");
    EXPECT_EQ(read(), "head\n5\n");
    EXPECT_TRUE(pipe.finish(milliseconds(0)));
    EXPECT_EQ(pipe.lost_rows(), 3U);
}

TEST_F(RowPipes, KeepRowsForAReaderThatIsSlowUpToABound) {
    read_from_here_on();
    RowPipe pipe(path_, "head\n");
    const std::string row = std::string(999, 'x') + '\n';
    for (int i = 0; i < 3000; ++i) pipe.put(row);
    const std::uint64_t lost = pipe.lost_rows();
    EXPECT_GT(lost, 1500U);
    EXPECT_LT(lost, 2000U);
    // It goes on where it was, with whole rows.
    std::string all = read();
    while (std::count(all.begin(), all.end(), '\n') < static_cast<std::int64_t>(3001 - lost)) {
        pipe.put("");
        all += read();
    }
    pipe.put("last\n");
    all += read();
    EXPECT_EQ(all.substr(0, 5), "head\n");
    EXPECT_EQ(all.substr(all.size() - 5), "last\n");
    EXPECT_EQ(all.size(), 5 + (3000 - lost) * 1000 + 5);
    EXPECT_EQ(pipe.lost_rows(), lost);
}

TEST_F(RowPipes, GiveUpAReaderThatTakesNothing) {
    read_from_here_on();
    RowPipe pipe(path_, "head\n");
    const std::string row = std::string(999, 'x') + '\n';
    for (int i = 0; i < 200; ++i) pipe.put(row);
    EXPECT_EQ(pipe.lost_rows(), 0U);
    EXPECT_FALSE(pipe.finish(milliseconds(10)));
    // One was written in part.
    const std::string all = read();
    EXPECT_EQ(pipe.lost_rows(), 200 - (all.size() - 5) / 1000);
}

TEST_F(RowPipes, AreWhatATableIsWrittenToIfNobodyIsToWait) {
    TableWriter unread(path_, {"a", "b"}, FullPipe::lose_rows);
    EXPECT_TRUE(unread.is_unread());
    const auto put_row = [&] {
        unread.cell(std::uint64_t{1});
        unread.cell(0.5);
        unread.end_row();
    };
    put_row();
    EXPECT_EQ(unread.lost_rows(), 1U);
    read_from_here_on();
    put_row();
    EXPECT_FALSE(unread.is_unread());
    EXPECT_EQ(read(), "a,b\n1,0.5\n");
    EXPECT_FALSE(unread.close());
}

}  // namespace
}  // namespace afferent
