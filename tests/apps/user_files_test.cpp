// Files from users: other people's, hostile ones, and ones of the wrong kind.
#include <nlohmann/json.hpp>
#include <sstream>

#include "afferent/io/files/hdf5_process.hpp"
#include "tests/apps/process.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

const std::string grasp = AFFERENT_SOURCE_DIR "/examples/grasp.txtpb";

// Each was changed so that Debian 12's library for HDF5 runs for ever or crashes. In every case the command
// ends soon, with an error that names the file.
TEST(HostileHdf5, HarmsNobody) {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(AFFERENT_SOURCE_DIR "/tests/apps/hostile")) {
        const auto read =
            Hdf5Process(HDF5_PROGRAM)
                .read(entry.path(), {.processor_time = std::chrono::seconds(1), .memory_mb = 1024});
        ASSERT_FALSE(read) << entry.path();
        EXPECT_EQ(read.error().text.rfind(entry.path().string() + ": ", 0), 0U) << read.error().text;
        ++files;
    }
    EXPECT_EQ(files, 4U);
}

TEST(HostileHdf5, IsToldByWhatItsReaderDied) {
    const Folder folder;
    write_file(folder / "a.nwb", "");
    const auto said = [&](const std::string& script) {
        write_file(folder / "reader", "#!/bin/sh\n" + script + "\n");
        fs::permissions(folder / "reader", fs::perms::owner_all);
        const auto read = Hdf5Process(folder / "reader").read(folder / "a.nwb");
        return read ? "read" : read.error().text.substr(folder("a.nwb").size() + 2);
    };
    EXPECT_EQ(said("kill -SEGV $$"),
              "the library for HDF5 has crashed on it (Segmentation fault). The file is "
              "damaged, or was made to do that");
    EXPECT_EQ(said("kill -XCPU $$"),
              "the library for HDF5 has not come to an end with it in 3 s of processor "
              "time. The file is damaged, or was made to do that");
    EXPECT_EQ(said("printf 'units is missing'; exit 1"), "units is missing");
    EXPECT_EQ(said("printf afferent"), "these are no events, or not all of them");
    const auto nobody = Hdf5Process("afferent-nowhere").read(folder / "a.nwb");
    ASSERT_FALSE(nobody);
    EXPECT_NE(nobody.error().text.find("Build it: scripts/build.sh release afferent-nowhere"),
              std::string::npos)
        << nobody.error().text;
}

class UserFiles : public testing::Test {
  protected:
    // The program's error; expects that it fails.
    static std::string refusal(std::vector<std::string> arguments) {
        Process process(std::move(arguments));
        EXPECT_GT(process.wait(), 0);
        return process.err();
    }

    std::string refusal_of_table(const std::string& table) {
        write_file(folder_ / "t.csv", table);
        return refusal({"run", grasp, "--table", folder_("t.csv")});
    }

    static void expect(const std::string& said, const std::string& text) {
        EXPECT_NE(said.find(text), std::string::npos) << said;
    }

    nlohmann::json summary_of(const std::string& scene) {
        write_file(folder_ / "s.txtpb", scene);
        Process run({"run", folder_("s.txtpb"), "--out", folder_("out"), "--json"});
        EXPECT_EQ(run.wait(), 0) << run.err();
        return nlohmann::json::parse(run.out());
    }

    // From force.csv: the first time at which the true force is known, and the force then.
    std::pair<double, double> first_known_force() const {
        std::istringstream rows(read_file(folder_ / "out/force.csv"));
        for (std::string row; std::getline(rows, row);) {
            const std::size_t comma = row.find(',');
            if (row.starts_with("time_s") || row[comma + 1] == ',') continue;
            return {std::stod(row), std::stod(row.substr(comma + 1))};
        }
        return {-1, -1};
    }

    const Folder folder_;
};

TEST_F(UserFiles, ThatCannotBeReadAreToldWithWhatToDo) {
    expect(refusal({"run", grasp, "--table", folder_("")}),
           "cannot be read: it is a folder; name a file in it");
    expect(refusal({"run", grasp, "--emg", folder_("")}),
           "cannot be read: it is a folder; name a file in it");
    expect(refusal({"run", grasp, "--table", folder_("none.csv")}),
           "none.csv: cannot be read: No such file or directory");
    expect(refusal({"run", folder_("none.txtpb")}), "none.txtpb: cannot be read: No such file or directory");
    expect(refusal({"plan", folder_("")}), "cannot be read: it is a folder; name a file in it");
    fs::create_directory(folder_ / "d.nwb");
    expect(refusal({"convert", folder_("d.nwb"), folder_("x.csv")}), "d.nwb: cannot be read: it is a folder");
    if (::geteuid() == 0) return;  // root may read everything
    write_file(folder_ / "secret.csv", "time_s,force_n\n0,1\n");
    fs::permissions(folder_ / "secret.csv", fs::perms::none);
    expect(refusal({"run", grasp, "--table", folder_("secret.csv")}),
           "cannot be read: Permission denied; chmod u+r gives its owner the right");
}

TEST_F(UserFiles, ThatCannotBeWrittenAreNamedOnce) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    write_file(folder_ / "e.csv", "time_s,address\n0.1,8\n");
    for (const std::string name : {"f.nwb", "f.sonata.h5", "f.csv"}) {
        fs::create_symlink("/dev/full", folder_ / name);
        EXPECT_EQ(refusal({"convert", folder_("e.csv"), folder_(name)}),
                  folder_(name) + ": cannot be written\n");
    }
}

TEST_F(UserFiles, ThatCannotBeWrittenAreToldWithTheReason) {
    const std::string nowhere = folder_("none/x");
    expect(refusal({"run", grasp, "--record", nowhere}),
           "none/x: cannot be written: No such file or directory");
    expect(refusal({"tune", grasp, "--out", nowhere}),
           "none/x: cannot be written: No such file or directory");
    expect(refusal({"tune", grasp, "--out", folder_("")}), ": cannot be written: Is a directory");
    EXPECT_EQ(Process({"keys", folder_("keys")}).wait(), 0);
    expect(refusal({"keys", folder_("keys")}),
           "keys/coprocessor.key: exists, and is not written over; name another folder");
}

TEST_F(UserFiles, InOtherUnitsAreToldHowToConvertThem) {
    expect(refusal_of_table("time_s,Force_g\n0,100\n"),
           "multiply \"Force_g\" by 0.00980665 and call it \"Force_n\"");
    expect(refusal_of_table("time_s,grip_kg\n0,1\n"),
           "multiply \"grip_kg\" by 9.80665 and call it \"grip_n\"");
    expect(refusal_of_table("time_s,grip\n0,1\n"), "rename \"grip\" if it is in one of these");
    write_file(folder_ / "t.csv", "time_s,force_n\n0,2048\n");
    write_file(folder_ / "s.txtpb", "source { table { path: \"t.csv\" out_of_range: REFUSE } }");
    expect(refusal({"run", folder_("s.txtpb")}), "Counts stand in columns that end in _counts");
}

TEST_F(UserFiles, AndOptionsThatDoNotFitAreToldWithWhatToDo) {
    write_file(folder_ / "s.txtpb", "duration_s: 1");
    expect(refusal({"run", folder_("s.txtpb"), "--record", folder_("r.afferent")}), "link { tcp {} }");
    expect(refusal({"run", grasp, "--seed", "x"}), "--seed: must be a number, is x");
    write_file(folder_ / "e.csv", "time_s,address\n0.1,9\n");
    expect(refusal({"convert", folder_("e.csv"), folder_("e.nwb"), "--scene", grasp}),
           "grasp.txtpb: these events are not of this scene: an event has address 9, and the patches have 9 "
           "afferents");
}

TEST_F(UserFiles, TellTheTrueForceFromTheirFirstSampleOn) {
    write_file(folder_ / "t.csv", "time_s,force_n\n2,5\n2.5,6\n");
    const auto late = summary_of(
        "duration_s: 3 record { picture: false } source { table { path: \"t.csv\" between: HOLD } }");
    EXPECT_TRUE(late.at("force_error_rms_n").is_number());
    EXPECT_EQ(first_known_force().second, 5);
    EXPECT_GE(first_known_force().first, 2) << "before, nobody knows";
}

// The calibration of this sensor is linear: 4095 counts are 10 N.
TEST_F(UserFiles, OfCountsTellTheTrueForceByTheirCalibration) {
    write_file(folder_ / "t.csv", "time_s,a_counts,b_counts\n0.5,819,1638\n1.5,0,9999\n");
    const auto summary = summary_of(
        "duration_s: 3 record { picture: false } patch { name: \"p\" elements: 2 } "
        "source { table { path: \"t.csv\" between: HOLD } }");
    EXPECT_TRUE(summary.at("force_error_rms_n").is_number());
    EXPECT_GE(first_known_force().first, 0.5);
    EXPECT_NEAR(first_known_force().second, 6, 1e-9);
}

}  // namespace
}  // namespace afferent
