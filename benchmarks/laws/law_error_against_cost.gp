# gnuplot benchmarks/laws/law_error_against_cost.gp, in the folder of law_error_against_cost.csv
set datafile separator ","
set terminal pngcairo size 900,600
set output "law_error_against_cost.png"
set title "Fracture-energy law: error of 256 cyclic mixed paths against run time"
set xlabel "run time of the law, microseconds a point and path"
set ylabel "error"
set logscale xy
set format y "10^{%T}"
set grid
set key at graph 0.98, 0.55
mixed(column) = strcol(1) eq "mixed" ? column : NaN
plot "law_error_against_cost.csv" using (mixed($7)):3 with linespoints pt 7 title "largest error of traction over strength", \
     "" using (mixed($7)):4 with linespoints pt 7 title "root mean square", \
     "" using (mixed($7)):5 with linespoints pt 7 title "dissipated energy", \
     "" using (strcol(1) ne "mixed" ? $7 : NaN):3 with points pt 4 title "monotonic paths, against closed forms (largest)"
