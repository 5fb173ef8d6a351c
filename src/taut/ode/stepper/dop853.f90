!> The Runge-Kutta pair of order 8(5,3) of Dormand and Prince with its continuous extension of order 7.
!!
!! Source: E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, Sects II.5,
!! II.6 (continuous extension) and II.10 (error estimates); coefficients as in the code DOP853 of E. Hairer and G. Wanner.
module taut_ode_stepper_dop853
   use taut_kinds, only: wp
   use taut_ode_step_control, only: controller_constants_t
   use taut_ode_stepper_explicit_pair, only: explicit_pair_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: dop853_t

   !> Number of stages; the last one is evaluated at the new state ('first same as last'). Three more are those of the
   !! continuous extension, evaluated where it is asked for.
   integer, parameter :: stages = 13, all_stages = 16
   !> Order of the solution that is continued.
   integer, parameter :: order = 8

   real(wp), parameter :: z(all_stages) = 0.0_wp

   !> Nodes c_i.
   real(wp), parameter :: node(all_stages) = [ &
      0.0_wp, 0.526001519587677318785587544488e-01_wp, 0.789002279381515978178381316732e-01_wp, &
      0.118350341907227396726757197510_wp, 0.281649658092772603273242802490_wp, 0.333333333333333333333333333333_wp, 0.25_wp, &
      0.307692307692307692307692307692_wp, 0.651282051282051282051282051282_wp, 0.6_wp, 0.857142857142857142857142857142_wp, &
      1.0_wp, 1.0_wp, 0.1_wp, 0.2_wp, 0.777777777777777777777777777778_wp]

   !> Coefficients a_ij, one column per stage i; column 13 holds the weights of order 8.
   real(wp), parameter :: a(all_stages - 1, all_stages) = reshape([ &
      z(:15), &
      5.26001519587677318785587544488e-2_wp, z(:14), &
      1.97250569845378994544595329183e-2_wp, 5.91751709536136983633785987549e-2_wp, z(:13), &
      2.95875854768068491816892993775e-2_wp, 0.0_wp, 8.87627564304205475450678981324e-2_wp, z(:12), &
      2.41365134159266685502369798665e-1_wp, 0.0_wp, -8.84549479328286085344864962717e-1_wp, &
      9.24834003261792003115737966543e-1_wp, z(:11), &
      3.7037037037037037037037037037e-2_wp, z(:2), 1.70828608729473871279604482173e-1_wp, &
      1.25467687566822425016691814123e-1_wp, z(:10), &
      3.7109375e-2_wp, z(:2), 1.70252211019544039314978060272e-1_wp, 6.02165389804559606850219397283e-2_wp, -1.7578125e-2_wp, &
      z(:9), &
      3.70920001185047927108779319836e-2_wp, z(:2), 1.70383925712239993810214054705e-1_wp, &
      1.07262030446373284651809199168e-1_wp, -1.53194377486244017527936158236e-2_wp, 8.27378916381402288758473766002e-3_wp, &
      z(:8), &
      6.24110958716075717114429577812e-1_wp, z(:2), -3.36089262944694129406857109825_wp, &
      -8.68219346841726006818189891453e-1_wp, 2.75920996994467083049415600797e1_wp, 2.01540675504778934086186788979e1_wp, &
      -4.34898841810699588477366255144e1_wp, z(:7), &
      4.77662536438264365890433908527e-1_wp, z(:2), -2.48811461997166764192642586468_wp, &
      -5.90290826836842996371446475743e-1_wp, 2.12300514481811942347288949897e1_wp, 1.52792336328824235832596922938e1_wp, &
      -3.32882109689848629194453265587e1_wp, -2.03312017085086261358222928593e-2_wp, z(:6), &
      -9.3714243008598732571704021658e-1_wp, z(:2), 5.18637242884406370830023853209_wp, 1.09143734899672957818500254654_wp, &
      -8.14978701074692612513997267357_wp, -1.85200656599969598641566180701e1_wp, 2.27394870993505042818970056734e1_wp, &
      2.49360555267965238987089396762_wp, -3.0467644718982195003823669022_wp, z(:5), &
      2.27331014751653820792359768449_wp, z(:2), -1.05344954667372501984066689879e1_wp, -2.00087205822486249909675718444_wp, &
      -1.79589318631187989172765950534e1_wp, 2.79488845294199600508499808837e1_wp, -2.85899827713502369474065508674_wp, &
      -8.87285693353062954433549289258_wp, 1.23605671757943030647266201528e1_wp, 6.43392746015763530355970484046e-1_wp, &
      z(:4), &
      5.42937341165687622380535766363e-2_wp, z(:4), 4.45031289275240888144113950566_wp, 1.89151789931450038304281599044_wp, &
      -5.8012039600105847814672114227_wp, 3.1116436695781989440891606237e-1_wp, -1.52160949662516078556178806805e-1_wp, &
      2.01365400804030348374776537501e-1_wp, 4.47106157277725905176885569043e-2_wp, z(:3), &
      5.61675022830479523392909219681e-2_wp, z(:5), 2.53500210216624811088794765333e-1_wp, &
      -2.46239037470802489917441475441e-1_wp, -1.24191423263816360469010140626e-1_wp, 1.5329179827876569731206322685e-1_wp, &
      8.20105229563468988491666602057e-3_wp, 7.56789766054569976138603589584e-3_wp, -8.298e-3_wp, z(:2), &
      3.18346481635021405060768473261e-2_wp, z(:4), 2.83009096723667755288322961402e-2_wp, &
      5.35419883074385676223797384372e-2_wp, -5.49237485713909884646569340306e-2_wp, z(:2), &
      -1.08347328697249322858509316994e-4_wp, 3.82571090835658412954920192323e-4_wp, -3.40465008687404560802977114492e-4_wp, &
      1.41312443674632500278074618366e-1_wp, 0.0_wp, &
      -4.28896301583791923408573538692e-1_wp, z(:4), -4.69762141536116384314449447206_wp, 7.68342119606259904184240953878_wp, &
      4.06898981839711007970213554331_wp, 3.56727187455281109270669543021e-1_wp, z(:3), &
      -1.39902416515901462129418009734e-3_wp, 2.9475147891527723389556272149_wp, -9.15095847217987001081870187138_wp], &
      [all_stages - 1, all_stages])

   !> Weights of order 8 less those of order 5.
   real(wp), parameter :: e5(12) = [ &
      0.1312004499419488073250102996e-1_wp, z(:4), -0.1225156446376204440720569753e+1_wp, -0.4957589496572501915214079952_wp, &
      0.1664377182454986536961530415e+1_wp, -0.3503288487499736816886487290_wp, 0.3341791187130174790297318841_wp, &
      0.8192320648511571246570742613e-1_wp, -0.2235530786388629525884427845e-1_wp]

   !> Weights of order 3.
   real(wp), parameter :: order_3(12) = [ &
      0.244094488188976377952755905512_wp, z(:7), 0.733846688281611857341361741547_wp, z(:2), &
      0.220588235294117647058823529412e-1_wp]

   !> Weights of the four highest terms of the continuous extension.
   real(wp), parameter :: d(all_stages, 4) = reshape([ &
      -0.84289382761090128651353491142e+1_wp, z(:4), 0.56671495351937776962531783590_wp, &
      -0.30689499459498916912797304727e+1_wp, 0.23846676565120698287728149680e+1_wp, 0.21170345824450282767155149946e+1_wp, &
      -0.87139158377797299206789907490_wp, 0.22404374302607882758541771650e+1_wp, 0.63157877876946881815570249290_wp, &
      -0.88990336451333310820698117400e-1_wp, 0.18148505520854727256656404962e+2_wp, -0.91946323924783554000451984436e+1_wp, &
      -0.44360363875948939664310572000e+1_wp, &
      0.10427508642579134603413151009e+2_wp, z(:4), 0.24228349177525818288430175319e+3_wp, &
      0.16520045171727028198505394887e+3_wp, -0.37454675472269020279518312152e+3_wp, -0.22113666853125306036270938578e+2_wp, &
      0.77334326684722638389603898808e+1_wp, -0.30674084731089398182061213626e+2_wp, -0.93321305264302278729567221706e+1_wp, &
      0.15697238121770843886131091075e+2_wp, -0.31139403219565177677282850411e+2_wp, -0.93529243588444783865713862664e+1_wp, &
      0.35816841486394083752465898540e+2_wp, &
      0.19985053242002433820987653617e+2_wp, z(:4), -0.38703730874935176555105901742e+3_wp, &
      -0.18917813819516756882830838328e+3_wp, 0.52780815920542364900561016686e+3_wp, -0.11573902539959630126141871134e+2_wp, &
      0.68812326946963000169666922661e+1_wp, -0.10006050966910838403183860980e+1_wp, 0.77771377980534432092869265740_wp, &
      -0.27782057523535084065932004339e+1_wp, -0.60196695231264120758267380846e+2_wp, 0.84320405506677161018159903784e+2_wp, &
      0.11992291136182789328035130030e+2_wp, &
      -0.25693933462703749003312586129e+2_wp, z(:4), -0.15418974869023643374053993627e+3_wp, &
      -0.23152937917604549567536039109e+3_wp, 0.35763911791061412378285349910e+3_wp, 0.93405324183624310003907691704e+2_wp, &
      -0.37458323136451633156875139351e+2_wp, 0.10409964950896230045147246184e+3_wp, 0.29840293426660503123344363579e+2_wp, &
      -0.43533456590011143754432175058e+2_wp, 0.96324553959188282948394950600e+2_wp, -0.39177261675615439165231486172e+2_wp, &
      -0.14972683625798562581422125276e+3_wp], [all_stages, 4])

   !> The pair; the parts of its continuous extension: (n, 8).
   type, extends(explicit_pair_t) :: dop853_t
      real(wp), allocatable, private :: dense(:, :), y_stage(:)
      !> Those of the integral that goes along.
      real(wp), private :: dense_integral(8) = 0.0_wp
   contains
      procedure :: init
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: integral_inside
      procedure, nopass :: estimate
   end type dop853_t

contains

   !> Allocates the workspace.
   subroutine init(self, n)
      !> The pair.
      class(dop853_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n

      self%order = order
      ! Those of the code DOP853: no memory of the error before.
      self%constants = controller_constants_t(exponent=1.0_wp/order, memory=0.0_wp, largest_decrease=0.333_wp, &
                                              largest_increase=6.0_wp)
      self%stability_bound = 6.1_wp
      call self%set_tableau(n, stages, node, a, 2)
      allocate (self%dense(n, 8), self%y_stage(n), source=0.0_wp)
   end subroutine init

   !> The solution of order 8 less those of order 5 and of order 3.
   pure subroutine estimate(h, k, error)
      !> Step [s].
      real(wp), intent(in) :: h
      !> Derivatives of all stages: (n, stages).
      real(wp), intent(in), contiguous :: k(:, :)
      !> Estimates of the local error, with order 5 and with order 3: (n, 2).
      real(wp), intent(out), contiguous :: error(:, :)
      integer :: i

      associate (b => a(:, stages))
         do i = 1, size(error, 1)
            error(i, 1) = h*(e5(1)*k(i, 1) + e5(6)*k(i, 6) + e5(7)*k(i, 7) + e5(8)*k(i, 8) + e5(9)*k(i, 9) + &
                             e5(10)*k(i, 10) + e5(11)*k(i, 11) + e5(12)*k(i, 12))
            error(i, 2) = h*((b(1) - order_3(1))*k(i, 1) + b(6)*k(i, 6) + b(7)*k(i, 7) + b(8)*k(i, 8) + &
                             (b(9) - order_3(9))*k(i, 9) + b(10)*k(i, 10) + b(11)*k(i, 11) + (b(12) - order_3(12))*k(i, 12))
         end do
      end associate
   end subroutine estimate

   !> The continuous extension of order 7, from the end state that is really continued (projected or not), by three more
   !! evaluations.
   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      !> The pair.
      class(dop853_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at the step's end [s].
      real(wp), intent(in) :: t_new
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y_new(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: i, j, l

      do i = stages + 1, all_stages
         call self%stage_state(i, h, y, self%y_stage)
         call self%evaluate(ode, t + node(i)*h, self%y_stage, self%k(:, i), info)
         if (info /= rhs_ok) return
         self%integrand(1, i) = ode%integrand
      end do
      associate (q => self%integrand(1, :), parts => self%dense_integral)
         parts(2) = self%gain
         parts(3) = h*q(1) - self%gain
         parts(4) = self%gain - h*q(stages) - parts(3)
         do l = 1, 4
            parts(4 + l) = h*dot_product(d(:, l), q(:all_stages))
         end do
      end associate
      associate (k => self%k, dense => self%dense)
         dense(:, 1) = y
         dense(:, 2) = y_new - y
         dense(:, 3) = h*k(:, 1) - dense(:, 2)
         dense(:, 4) = dense(:, 2) - h*k(:, stages) - dense(:, 3)
         do l = 1, 4
            dense(:, 4 + l) = d(1, l)*k(:, 1)
            do j = 6, all_stages
               dense(:, 4 + l) = dense(:, 4 + l) + d(j, l)*k(:, j)
            end do
            dense(:, 4 + l) = h*dense(:, 4 + l)
         end do
      end associate
      associate (unused_end => t_new)
      end associate
   end subroutine prepare_dense

   !> The continuous extension at a fraction of the step.
   subroutine interpolate(self, theta, y)
      !> The pair.
      class(dop853_t), intent(in) :: self
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      real(wp) :: rest
      integer :: i

      rest = 1.0_wp - theta
      associate (dense => self%dense)
         do i = 1, size(y)
            y(i) = dense(i, 1) + theta*(dense(i, 2) + rest*(dense(i, 3) + theta*(dense(i, 4) + rest*( &
                   dense(i, 5) + theta*(dense(i, 6) + rest*(dense(i, 7) + theta*dense(i, 8)))))))
         end do
      end associate
   end subroutine interpolate

   !> The continuous extension of the integral that goes along.
   pure function integral_inside(self, h, theta) result(value)
      !> The pair, behind `prepare_dense`.
      class(dop853_t), intent(in) :: self
      !> The step's length: not asked.
      real(wp), intent(in) :: h
      !> Fraction of the step.
      real(wp), intent(in) :: theta
      !> The integral, zero at the step's start.
      real(wp) :: value
      real(wp) :: rest

      rest = 1.0_wp - theta
      associate (parts => self%dense_integral)
         value = theta*(parts(2) + rest*(parts(3) + theta*(parts(4) + rest*( &
                 parts(5) + theta*(parts(6) + rest*(parts(7) + theta*parts(8)))))))
      end associate
      associate (unused_step => h)
      end associate
   end function integral_inside

end module taut_ode_stepper_dop853
