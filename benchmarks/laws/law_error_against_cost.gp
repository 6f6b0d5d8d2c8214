# gnuplot benchmarks/laws/law_error_against_cost.gp, in the folder of law_error_against_cost.csv
set datafile separator ","
set terminal pngcairo size 1500,620
set output "law_error_against_cost.png"
set xlabel "run time of the law, microseconds a point and path"
set ylabel "error"
set logscale xy
set xrange [0.4:1e4]
set format y "10^{%T}"
set grid
set key at graph 0.98, 0.45
of(law, path, number) = strcol(1) eq law && strcol(2) eq path ? column(number) : NaN
csv = "law_error_against_cost.csv"
set multiplot layout 1,2 title "Error of 256 cyclic mixed paths against run time"
set title "fracture\\_energy"
law = "fracture_energy"
plot csv using (of(law, "mixed", 8)):4 with linespoints pt 7 title "largest error of traction over strength", \
     "" using (of(law, "mixed", 8)):5 with linespoints pt 7 title "root mean square", \
     "" using (of(law, "mixed", 8)):6 with linespoints pt 7 title "dissipated energy", \
     "" using (strcol(1) eq law && strcol(2) ne "mixed" ? $8 : NaN):4 with points pt 4 title "monotonic paths, against closed forms (largest)"
set title "cyclic\\_joint, starting values of its page"
set yrange [1e-4:1e5]
set key at graph 0.98, 0.97
law = "cyclic_joint"
plot csv using (of(law, "mixed", 8)):4 with linespoints pt 7 title "the same paths: largest error of traction over strength", \
     "" using (of(law, "mixed", 8)):5 with linespoints pt 7 title "root mean square", \
     "" using (of(law, "mixed", 8)):6 with linespoints pt 7 title "dissipated energy", \
     "" using (of(law, "crushing", 8)):4 with linespoints pt 4 dt 2 title "crushing as well: largest", \
     "" using (of(law, "crushing", 8)):5 with linespoints pt 4 dt 2 title "root mean square", \
     "" using (of(law, "crushing", 8)):6 with linespoints pt 4 dt 2 title "dissipated energy"
unset multiplot
