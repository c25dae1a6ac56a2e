"""Flight Review's own code on a log, without its server: `flight_review.py FOLDER LOG`, in a Python with its requirements.

Prints a JSON object: the titles of the plots of its log page and of its PID analysis, and the information table's text.
Nothing is fetched: what it would download (names of airframes and parameters) is for its labels only.
"""

import json
import os
import re
import sys
from contextlib import redirect_stdout
from types import SimpleNamespace


def titles(plots):
    return [plot.title.text for plot in plots if getattr(plot, "title", None) is not None]


def main(folder, path):
    log = os.path.abspath(path)
    os.chdir(os.path.join(folder, "app"))
    sys.path.insert(0, os.path.join(os.getcwd(), "plot_app"))
    import configured_plots
    import helper
    import pid_analysis_plots
    import plotted_tables
    from db_entry import DBData
    from pyulog.px4 import PX4ULog

    plotted_tables.get_logged_events = lambda ulog: []
    for module in (helper, plotted_tables):
        module.download_file_maybe = lambda *_: 0
    request = SimpleNamespace(headers={}, arguments={})
    page = SimpleNamespace(template_variables={}, session_context=SimpleNamespace(request=request))
    configured_plots.curdoc = pid_analysis_plots.curdoc = lambda: page
    ulog = helper.load_ulog_file(log)
    px4 = PX4ULog(ulog)
    px4.add_roll_pitch_yaw()
    plots = configured_plots.generate_plots(ulog, px4, DBData(), None, "3d", "pid")
    table = re.sub("<[^>]+>", " ", page.template_variables["info_table_html"])
    analysis = pid_analysis_plots.get_pid_analysis_plots(ulog, px4, DBData(), "log")
    return {"plots": titles(plots), "pid_analysis": titles(analysis), "table": " ".join(table.split())}


if __name__ == "__main__":
    with redirect_stdout(sys.stderr):
        result = main(*sys.argv[1:])
    print(json.dumps(result))
